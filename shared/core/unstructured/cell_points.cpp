#include "shared/core/unstructured/cell_points.h"

#include <algorithm>
#include <cmath>

#include "shared/core/base/matrix3.h"

namespace isosplat {
namespace {

constexpr int kMostSteps = 10;
constexpr int kHalvings = 24;
/// The mean of the positions where the edges of a cell have the isovalue, in its coordinates. An
/// edge counts for each of its two faces. At least one edge has values on both sides.
Vec3d edge_crossings(CellShape shape, const std::array<double, kMostCorners>& values,
                     double isovalue) {
  Vec3d sum;
  double count = 0;
  for (const CellFace& face : faces_of(shape)) {
    const size_t corners = face[3] < 0 ? 3 : 4;
    for (size_t i = 0; i < corners; ++i) {
      const auto a = static_cast<size_t>(face[i]);
      const auto b = static_cast<size_t>(face[(i + 1) % corners]);
      if ((values[a] <= isovalue) == (values[b] <= isovalue)) continue;
      const double part = (isovalue - values[a]) / (values[b] - values[a]);
      sum = sum + shape_corner(shape, a) * (1 - part) + shape_corner(shape, b) * part;
      ++count;
    }
  }
  return sum * (1 / count);
}

/// The farthest position from `from` towards `from + step` that is in the cell.
Vec3d moved_within(CellShape shape, Vec3d from, Vec3d step) {
  if (is_in_shape(shape, from + step)) return from + step;
  double inside = 0, outside = 1;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = (inside + outside) / 2;
    (is_in_shape(shape, from + step * middle) ? inside : outside) = middle;
  }
  return from + step * inside;
}

/// The field of a cell at a position in its coordinates.
struct CellField {
  double value = 0;
  Vec3d position;
  Vec3d gradient;  ///< in the world; 0 where the mapping of the cell is flat
  Matrix3d
      to_coordinates{};  ///< its transpose maps a vector of the world to the cell's coordinates

  CellField(const CellGeometry& cell, const std::array<double, kMostCorners>& values, Vec3d at) {
    const ShapeFunctions functions = shape_functions(cell.shape, at);
    const Vec3d first = cell.corners[0];
    Vec3d x, y, z, along;
    for (size_t i = 0; i < static_cast<size_t>(cell.count()); ++i) {
      // Relative to a corner: large offsets cost no digits.
      const Vec3d corner = cell.corners[i] - first, slope = functions.slopes[i];
      value += values[i] * functions.at[i];
      position = position + corner * functions.at[i];
      x = x + slope * corner.x;
      y = y + slope * corner.y;
      z = z + slope * corner.z;
      along = along + slope * values[i];
    }
    position = position + first;
    // Row by row: the derivatives of each coordinate of the world.
    const Matrix3d jacobian{x.x, x.y, x.z, y.x, y.y, y.z, z.x, z.y, z.z};
    if (!(std::abs(determinant(jacobian)) > 0)) return;
    to_coordinates = inverse_transpose(jacobian);
    gradient = multiply(to_coordinates, along);
  }
};

}  // namespace

std::optional<CellPoint> point_of_cell(const UnstructuredMesh& mesh, size_t cell, double isovalue) {
  const auto corners = mesh.corners_of(cell);
  std::array<double, kMostCorners> values{};
  for (size_t i = 0; i < corners.size(); ++i) values[i] = mesh.values[corners[i]];
  const auto [least, most] = std::minmax_element(values.begin(), values.begin() + corners.size());
  if (!(*least <= isovalue && isovalue < *most)) return std::nullopt;
  const float size = mesh.size(cell);
  if (!(size > 0)) return std::nullopt;
  const CellGeometry geometry = mesh.geometry(cell);
  const double enough = 1e-9 * (*most - *least);
  Vec3d at = edge_crossings(geometry.shape, values, isovalue);
  for (int i = 0; i < kMostSteps; ++i) {
    const CellField field(geometry, values, at);
    const double missing = isovalue - field.value, squared = dot(field.gradient, field.gradient);
    if (std::abs(missing) <= enough || !(squared > 0)) break;
    const Vec3d step = field.gradient * (missing / squared);
    const Vec3d next =
        moved_within(geometry.shape, at, multiply_transposed(field.to_coordinates, step));
    if (next == at) break;
    at = next;
  }
  const CellField field(geometry, values, at);
  const double steepness = length(field.gradient);
  if (!(steepness > 0) || !std::isfinite(steepness)) return std::nullopt;
  return CellPoint{field.position, field.gradient * (-1 / steepness), size};
}

}  // namespace isosplat
