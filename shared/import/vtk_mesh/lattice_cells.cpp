#include "shared/import/vtk_mesh/lattice_cells.h"

#include <algorithm>

#include "shared/import/vtk_mesh/ghosts.h"
#include "shared/import/vtk_mesh/points.h"

namespace isosplat::import {

Result<AddedCells> add_vtk_lattice_cells(MeshBuilder& builder, const VtkXmlFile& file,
                                         const VtkXmlPiece& piece, const VtkXmlExtent& used,
                                         uint64_t memory_bytes) {
  UnstructuredMesh& mesh = builder.mesh;
  AddedCells added;
  const uint64_t points = vtk_points_of(file, piece), cells = vtk_cells_of(file, piece);
  std::array<uint64_t, 3> n{}, low{}, high{};  // points along the axes, and the cells that are used
  uint64_t count = 1;
  for (size_t axis = 0; axis < 3; ++axis) {
    n[axis] = static_cast<uint64_t>(piece.extent.high[axis] - piece.extent.low[axis] + 1);
    low[axis] = static_cast<uint64_t>(used.low[axis] - piece.extent.low[axis]);
    high[axis] = static_cast<uint64_t>(used.high[axis] - piece.extent.low[axis]);
    count *= high[axis] - low[axis];
  }
  constexpr uint64_t kCellBytes = sizeof(CellShape) + (1 + 1 + 8) * sizeof(uint32_t);
  if (count * kCellBytes + (cells + points) / 8 > memory_bytes ||
      mesh.corners.size() + 8 * count > 0xffffffffu) {
    return vtk_mesh_too_large(file.path, memory_bytes);
  }
  if (count == 0) return added;
  const auto left_out = left_out_vtk_cells(file, piece, cells);
  if (!left_out) return tl::unexpected(left_out.error());
  const auto hidden = hidden_vtk_points(file, piece, points);
  if (!hidden) return tl::unexpected(hidden.error());
  added.numbers.reserve(static_cast<size_t>(count));
  const uint64_t first_point = mesh.points.size() - points;
  for (uint64_t z = low[2]; z < high[2]; ++z) {
    for (uint64_t y = low[1]; y < high[1]; ++y) {
      for (uint64_t x = low[0]; x < high[0]; ++x) {
        const uint64_t cell = (z * (n[1] - 1) + y) * (n[0] - 1) + x;
        const uint64_t point = (z * n[1] + y) * n[0] + x, up = n[0] * n[1];
        const uint64_t corners[] = {
            point,      point + 1,      point + n[0] + 1,      point + n[0],
            point + up, point + up + 1, point + up + n[0] + 1, point + up + n[0]};
        const auto is_hidden = [&](uint64_t at) { return (*hidden)[static_cast<size_t>(at)]; };
        if ((!left_out->empty() && (*left_out)[static_cast<size_t>(cell)]) ||
            (!hidden->empty() && std::any_of(std::begin(corners), std::end(corners), is_hidden))) {
          ++added.ghosts;
          continue;
        }
        mesh.begins.push_back(static_cast<uint32_t>(mesh.corners.size()));
        mesh.shapes.push_back(CellShape::hexahedron);
        for (const uint64_t at : corners) {
          mesh.corners.push_back(static_cast<uint32_t>(first_point + at));
        }
        added.numbers.push_back(static_cast<uint32_t>(cell));
      }
    }
  }
  added.cells = added.numbers.size();
  return added;
}

}  // namespace isosplat::import
