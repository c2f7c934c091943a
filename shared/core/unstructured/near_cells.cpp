#include "shared/core/unstructured/near_cells.h"

#include <algorithm>
#include <cmath>

namespace isosplat {
namespace {

/// The quick test of tetrahedra leaves out points that are this far outside in coordinates of the
/// cell. Others are tested again as exactly as all cells.
constexpr double kQuickTolerance = 1e-4;
/// Tetrahedra whose volume is smaller, relative to a cube with their longest edge, are not tested
/// quickly: the rounding of their weights may be larger.
constexpr double kQuickVolume = 1e-6;

}  // namespace

Box wide_box(const UnstructuredMesh& mesh, size_t cell) {
  const Box box = mesh.box(cell);
  const Vec3d margin = (box.high - box.low) * kBoxMargin;
  return {box.low - margin, box.high + margin};
}

void NearCells::assign(std::span<const uint32_t> cells) {
  cells_.resize(cells.size());
  for (size_t i = 0; i < cells.size(); ++i) {
    Cell& to = cells_[i];
    to.cell = cells[i];
    to.box = wide_box(mesh_, cells[i]);
    to.has_weights = false;
    if (mesh_.shapes[cells[i]] != CellShape::tetrahedron) continue;
    const auto corners = mesh_.corners_of(cells[i]);
    to.first = mesh_.points[corners[0]];
    const Vec3d a = mesh_.points[corners[1]] - to.first, b = mesh_.points[corners[2]] - to.first,
                c = mesh_.points[corners[3]] - to.first;
    const Vec3d bc = cross(b, c);
    const double volume = dot(a, bc);
    const double longest = std::sqrt(std::max({dot(a, a), dot(b, b), dot(c, c)}));
    to.has_weights = std::abs(volume) > kQuickVolume * longest * longest * longest;
    to.weights[0] = bc * (1 / volume);
    to.weights[1] = cross(c, a) * (1 / volume);
    to.weights[2] = cross(a, b) * (1 / volume);
  }
}

std::optional<CornerWeights> NearCells::weights(size_t cell, Vec3d point) const {
  if (mesh_.shapes[cell] != CellShape::tetrahedron) {
    return weights_in_cell(mesh_.geometry(cell), point);
  }
  const auto from = mesh_.corners_of(cell);
  const auto& points = mesh_.points;
  return weights_in_tetrahedron(
      {points[from[0]], points[from[1]], points[from[2]], points[from[3]]}, point);
}

std::optional<Located> NearCells::find(std::span<const uint32_t> numbers, Vec3d point) const {
  for (const uint32_t number : numbers) {
    const Cell& each = cells_[number];
    if (!each.box.contains(point)) continue;
    if (each.has_weights) {
      const Vec3d at = point - each.first;
      const double x = dot(each.weights[0], at), y = dot(each.weights[1], at),
                   z = dot(each.weights[2], at);
      if (std::min({x, y, z, 1 - x - y - z}) < -kQuickTolerance) continue;
    }
    if (const auto found = weights(each.cell, point)) {
      return Located{each.cell, mesh_.value(each.cell, *found)};
    }
  }
  return std::nullopt;
}

}  // namespace isosplat
