#include "shared/import/vtk_mesh/points.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "shared/import/vtk_xml/numbers.h"

namespace isosplat::import {
namespace {

constexpr uint64_t kTooMany = uint64_t{1} << 32;

bool is_position(double number) {
  return std::isfinite(number) && std::abs(number) < 1e100;
}

uint64_t product(const VtkXmlExtent& extent, int64_t more) {
  uint64_t count = 1;
  for (size_t axis = 0; axis < 3; ++axis) {
    const int64_t along = extent.high[axis] - extent.low[axis] + more;
    if (along <= 0) return 0;
    count *= static_cast<uint64_t>(along);  // below 2^32 times at most 2^32
    if (count >= kTooMany) return kTooMany;
  }
  return count;
}

Result<void> add_positions(std::vector<Vec3d>& points, const VtkXmlFile& file,
                           const VtkXmlPiece& piece, uint64_t total) {
  if (piece.positions.size() != 1 || piece.positions.front().components != 3) {
    return malformed_vtk_xml(file.path, "expected an array of 3 components in <Points>");
  }
  Vec3d point{0, 0, 0};
  int axis = 0;
  bool is_finite = true;
  auto read = visit_vtk_xml_numbers(
      file, piece.positions.front(), 3 * vtk_points_of(file, piece), [&](double position) {
        // The size in the file has been checked.
        if (points.empty()) points.reserve(static_cast<size_t>(total));
        is_finite = is_position(position);
        (axis == 0 ? point.x : axis == 1 ? point.y : point.z) = position;
        axis = (axis + 1) % 3;
        if (axis == 0) points.push_back(point);
        return is_finite;
      });
  if (!read || is_finite) return read;
  return malformed_vtk_xml(file.path, fmt::format("expected finite positions of points, found "
                                                  "others at point {}",
                                                  points.size()));
}

/// The coordinates along an axis.
Result<std::vector<double>> coordinates_of(const VtkXmlFile& file, const VtkXmlPiece& piece,
                                           size_t axis) {
  if (piece.coordinates.size() != 3 || piece.coordinates[axis].components != 1) {
    return malformed_vtk_xml(file.path, "expected <Coordinates> of x, y and z");
  }
  const auto count = static_cast<uint64_t>(piece.extent.high[axis] - piece.extent.low[axis] + 1);
  auto found = read_vtk_xml_numbers(file, piece.coordinates[axis], count);
  if (!found) return found;
  const bool are_finite = std::all_of(found->begin(), found->end(), is_position);
  const auto is_sorted = [&](auto order) {
    // No neighbour may be equal.
    return std::adjacent_find(found->begin(), found->end(), order) == found->end();
  };
  if (are_finite && (is_sorted(std::greater_equal<>()) || is_sorted(std::less_equal<>()))) {
    return found;
  }
  return malformed_vtk_xml(
      file.path, fmt::format("expected finite coordinates along {} that increase or decrease from "
                             "each to the next, found others",
                             "xyz"[axis]));
}

Result<void> add_products(std::vector<Vec3d>& points, const VtkXmlFile& file,
                          const VtkXmlPiece& piece, uint64_t total) {
  std::array<std::vector<double>, 3> along;
  for (size_t axis = 0; axis < 3; ++axis) {
    auto found = coordinates_of(file, piece, axis);
    if (!found) return tl::unexpected(found.error());
    along[axis] = std::move(*found);
  }
  if (points.empty()) points.reserve(static_cast<size_t>(total));
  for (const double z : along[2]) {
    for (const double y : along[1]) {
      for (const double x : along[0]) points.push_back({x, y, z});
    }
  }
  return {};
}

}  // namespace

uint64_t vtk_points_of(const VtkXmlFile& file, const VtkXmlPiece& piece) {
  return file.grid == VtkXmlGrid::unstructured ? piece.points : product(piece.extent, 1);
}

uint64_t vtk_cells_of(const VtkXmlFile& file, const VtkXmlPiece& piece) {
  return file.grid == VtkXmlGrid::unstructured ? piece.cells : product(piece.extent, 0);
}

Result<void> add_vtk_points(UnstructuredMesh& mesh, const VtkXmlFile& file,
                            const VtkXmlPiece& piece, uint64_t total) {
  return file.grid == VtkXmlGrid::rectilinear ? add_products(mesh.points, file, piece, total)
                                              : add_positions(mesh.points, file, piece, total);
}

}  // namespace isosplat::import
