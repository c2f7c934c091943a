#include "shared/mesh/block_mesh.h"

#include "shared/mesh/cell_surface.h"

namespace isosplat {
namespace {

/// Lattice points of a block along each axis.
constexpr uint32_t kPoints = kBlockCells + 1;

/// The trilinear gradient at a point of a cell, in values per cell.
Vec3f gradient_at(const std::array<double, 8>& v, double x, double y, double z) {
  const auto mix = [](double a, double b, double t) { return a + t * (b - a); };
  return {static_cast<float>(
              mix(mix(v[1] - v[0], v[3] - v[2], y), mix(v[5] - v[4], v[7] - v[6], y), z)),
          static_cast<float>(
              mix(mix(v[2] - v[0], v[3] - v[1], x), mix(v[6] - v[4], v[7] - v[5], x), z)),
          static_cast<float>(
              mix(mix(v[4] - v[0], v[5] - v[1], x), mix(v[6] - v[2], v[7] - v[3], x), y))};
}

bool is_on_border(Index3 low, int axis, Index3 cells) {
  const auto touches = [](int32_t at, int32_t count) { return at == 0 || at == count; };
  return (axis != 0 && touches(low.x, cells.x)) || (axis != 1 && touches(low.y, cells.y)) ||
         (axis != 2 && touches(low.z, cells.z));
}

}  // namespace

BlockMesher::BlockMesher() : vertex_of_(size_t{3} * kPoints * kPoints * kPoints) {}

/// The vertex on an edge of the cell at `low`, whose gradient this adds to.
uint32_t BlockMesher::vertex_at(int edge, Index3 low, const std::array<double, 8>& values,
                                BlockMesh& mesh) {
  const int axis = axis_of(edge), corner = low_corner(edge);
  const Index3 at{low.x + (corner & 1), low.y + (corner >> 1 & 1), low.z + (corner >> 2)};
  const double first = values[size_t(corner)], last = values[size_t(high_corner(edge))];
  const double t = first / (first - last);
  const uint32_t entry =
      ((static_cast<uint32_t>(at.z) * kPoints + static_cast<uint32_t>(at.y)) * kPoints +
       static_cast<uint32_t>(at.x)) *
          3 +
      static_cast<uint32_t>(axis);
  uint32_t& known = vertex_of_[entry];
  if (known == 0) {
    Vec3f position{static_cast<float>(at.x), static_cast<float>(at.y), static_cast<float>(at.z)};
    (axis == 0 ? position.x : axis == 1 ? position.y : position.z) += static_cast<float>(t);
    const auto index = static_cast<uint32_t>(mesh.vertices.size());
    mesh.vertices.push_back({position, {}});
    if (is_on_border(at, axis, cells_)) {
      mesh.border.push_back(
          {index, {{origin_.x + at.x, origin_.y + at.y, origin_.z + at.z}, axis}});
    }
    known = index + 1;
    used_.push_back(entry);
  }
  const auto along = [&](int a) { return a == axis ? t : double(corner >> a & 1); };
  const Vec3f gradient = gradient_at(values, along(0), along(1), along(2));
  MeshVertex& vertex = mesh.vertices[known - 1];
  vertex.gradient = vertex.gradient + gradient;
  return known - 1;
}

void BlockMesher::add_cell(uint32_t place, const CellCorners& corners, BlockMesh& mesh) {
  std::array<double, 8> values;
  uint32_t signs = 0;
  for (size_t i = 0; i < 8; ++i) {
    values[i] = double{1} * corners[i] - isovalue_;
    signs |= uint32_t{values[i] > 0} << i;
  }
  // The interval of a coarse cell goes beyond its corners.
  if (signs == 0 || signs == 255) return;
  const CellTriangles* surface = simple_cell_surface(static_cast<CornerSigns>(signs));
  if (!surface) surface = &cell_surface(values);
  const Index3 low{static_cast<int32_t>(place & 63), static_cast<int32_t>(place >> 6 & 63),
                   static_cast<int32_t>(place >> 12 & 63)};
  std::array<uint32_t, kCellEdges> vertices;
  for (int edge = 0; edge < kCellEdges; ++edge) {
    if ((signs >> low_corner(edge) & 1) != (signs >> high_corner(edge) & 1)) {
      vertices[size_t(edge)] = vertex_at(edge, low, values, mesh);
    }
  }
  const auto first_mean = static_cast<uint32_t>(mesh.vertices.size());
  for (const auto& loop : surface->means) {
    MeshVertex mean{};
    const float share = 1 / static_cast<float>(loop.size());
    for (const CellEdge edge : loop) {
      mean.position = mean.position + mesh.vertices[vertices[edge]].position * share;
    }
    const Vec3f at = mean.position;
    mean.gradient =
        gradient_at(values, at.x - double(low.x), at.y - double(low.y), at.z - double(low.z));
    mesh.vertices.push_back(mean);
  }
  for (const CellTriangle& triangle : surface->triangles) {
    std::array<uint32_t, 3> indices;
    for (size_t i = 0; i < 3; ++i) {
      indices[i] =
          triangle[i] < kCellEdges ? vertices[triangle[i]] : first_mean + triangle[i] - kCellEdges;
    }
    mesh.triangles.push_back(indices);
  }
}

void BlockMesher::run(const DecodedCells& cells, Index3 block_cells, Index3 origin,
                      float quantized_isovalue, BlockMesh& mesh) {
  mesh.vertices.clear();
  mesh.border.clear();
  mesh.triangles.clear();
  cells_ = block_cells;
  origin_ = origin;
  isovalue_ = double{quantized_isovalue};
  for (size_t i = 0; i < cells.cell.size(); ++i) {
    if (!is_active(cells.interval[i], quantized_isovalue)) continue;
    add_cell(cells.cell[i], cells.corners[i], mesh);
  }
  for (const uint32_t entry : used_) vertex_of_[entry] = 0;
  used_.clear();
}

}  // namespace isosplat
