#include "shared/core/unstructured/cell_shape.h"

#include <algorithm>
#include <cmath>

#include "shared/core/unstructured/linear_solve.h"

namespace isosplat {
namespace {

constexpr CellFace kTetrahedron[] = {{0, 1, 3, -1}, {1, 2, 3, -1}, {2, 0, 3, -1}, {0, 2, 1, -1}};
constexpr CellFace kPyramid[] = {
    {0, 3, 2, 1}, {0, 1, 4, -1}, {1, 2, 4, -1}, {2, 3, 4, -1}, {3, 0, 4, -1}};
constexpr CellFace kWedge[] = {
    {0, 1, 2, -1}, {3, 5, 4, -1}, {0, 3, 4, 1}, {1, 4, 5, 2}, {2, 5, 3, 0}};
constexpr CellFace kHexahedron[] = {{0, 4, 7, 3}, {1, 2, 6, 5}, {0, 1, 5, 4},
                                    {3, 7, 6, 2}, {0, 3, 2, 1}, {4, 5, 6, 7}};

/// Steps of Newton's method. It converges quadratically, in some five steps where cells are convex.
constexpr int32_t kMostSteps = 20;
constexpr double kLastStep = 1e-10;
/// Coordinates of points in the bounding box of a cell are not larger, unless the method diverges.
constexpr double kFar = 100;

/// The corner of a hexahedron in coordinates of the cell.
Vec3d unit_corner(size_t corner) {
  return {(corner & 3) == 1 || (corner & 3) == 2 ? 1.0 : 0.0, (corner & 2) ? 1.0 : 0.0,
          corner >= 4 ? 1.0 : 0.0};
}

ShapeFunctions hexahedron(Vec3d p) {
  ShapeFunctions w;
  for (size_t i = 0; i < 8; ++i) {
    const Vec3d c = unit_corner(i);
    const double x = c.x > 0 ? p.x : 1 - p.x, y = c.y > 0 ? p.y : 1 - p.y,
                 z = c.z > 0 ? p.z : 1 - p.z;
    w.at[i] = x * y * z;
    w.slopes[i] = {(2 * c.x - 1) * y * z, (2 * c.y - 1) * x * z, (2 * c.z - 1) * x * y};
  }
  return w;
}

ShapeFunctions wedge(Vec3d p) {
  const std::array<double, 3> flat{1 - p.x - p.y, p.x, p.y};
  constexpr Vec3d kSlopes[] = {{-1, -1, 0}, {1, 0, 0}, {0, 1, 0}};
  ShapeFunctions w;
  for (size_t i = 0; i < 6; ++i) {
    const size_t k = i % 3;
    const double along = i < 3 ? 1 - p.z : p.z;
    w.at[i] = flat[k] * along;
    w.slopes[i] = kSlopes[k] * along + Vec3d{0, 0, i < 3 ? -flat[k] : flat[k]};
  }
  return w;
}

/// With u = r (1 − t), v = s (1 − t), w = 1 − t, VTK's shape functions are those of a tetrahedron
/// with the term u v / w of the base's fourth corner.
ShapeFunctions pyramid(Vec3d p) {
  const double safe = std::abs(p.z) < 1e-12 ? 1e-12 : p.z;
  const double mixed = p.x * p.y / safe;
  const Vec3d slope{p.y / safe, p.x / safe, -mixed / safe};
  ShapeFunctions w;
  w.at = {p.z - p.x - p.y + mixed, p.x - mixed, mixed, p.y - mixed, 1 - p.z, 0, 0, 0};
  w.slopes = {Vec3d{-1, -1, 1} + slope, Vec3d{1, 0, 0} - slope, slope, Vec3d{0, 1, 0} - slope,
              Vec3d{0, 0, -1}};
  return w;
}

ShapeFunctions tetrahedron(Vec3d p) {
  ShapeFunctions w;
  w.at = {1 - p.x - p.y - p.z, p.x, p.y, p.z, 0, 0, 0, 0};
  w.slopes = {Vec3d{-1, -1, -1}, Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}};
  return w;
}

Vec3d centre(CellShape shape) {
  switch (shape) {
    case CellShape::tetrahedron:
      return {0.25, 0.25, 0.25};
    case CellShape::pyramid:
      return {0.375, 0.375, 0.75};
    case CellShape::wedge:
      return {1.0 / 3, 1.0 / 3, 0.5};
    case CellShape::hexahedron:
      break;
  }
  return {0.5, 0.5, 0.5};
}

}  // namespace

std::span<const CellFace> faces_of(CellShape shape) {
  switch (shape) {
    case CellShape::tetrahedron:
      return kTetrahedron;
    case CellShape::pyramid:
      return kPyramid;
    case CellShape::wedge:
      return kWedge;
    case CellShape::hexahedron:
      break;
  }
  return kHexahedron;
}

ShapeFunctions shape_functions(CellShape shape, Vec3d at) {
  switch (shape) {
    case CellShape::tetrahedron:
      return tetrahedron(at);
    case CellShape::pyramid:
      return pyramid(at);
    case CellShape::wedge:
      return wedge(at);
    case CellShape::hexahedron:
      break;
  }
  return hexahedron(at);
}

bool is_in_shape(CellShape shape, Vec3d p) {
  const double low = std::min({p.x, p.y, p.z});
  if (!(low >= -kInsideTolerance)) return false;
  const double most = 1 + kInsideTolerance;
  switch (shape) {
    case CellShape::tetrahedron:
      return p.x + p.y + p.z <= most;
    case CellShape::pyramid:
      return p.z <= most && std::max(p.x, p.y) <= p.z + kInsideTolerance;
    case CellShape::wedge:
      return p.x + p.y <= most && p.z <= most;
    case CellShape::hexahedron:
      break;
  }
  return std::max({p.x, p.y, p.z}) <= most;
}

Vec3d shape_corner(CellShape shape, size_t corner) {
  constexpr Vec3d kTriangle[] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  switch (shape) {
    case CellShape::tetrahedron:
      return corner < 3 ? kTriangle[corner] : Vec3d{0, 0, 1};
    case CellShape::pyramid:
      return corner < 4 ? unit_corner(corner + 4) : Vec3d{0, 0, 0};
    case CellShape::wedge:
      return kTriangle[corner % 3] + Vec3d{0, 0, corner < 3 ? 0.0 : 1.0};
    case CellShape::hexahedron:
      break;
  }
  return unit_corner(corner);
}

CornerWeights shape_weights(CellShape shape, Vec3d at) {
  return shape_functions(shape, at).at;
}

std::optional<CornerWeights> weights_in_tetrahedron(const std::array<Vec3d, 4>& corners,
                                                    Vec3d point) {
  // Positions are relative to the first corner: large offsets cost no digits. Relative to the
  // centre, errors are smallest inside.
  const Vec3d first = corners[0], a = corners[1] - first, b = corners[2] - first,
              c = corners[3] - first;
  const Vec3d from = centre(CellShape::tetrahedron);
  const Vec3d position = a * from.x + b * from.y + c * from.z;
  const auto change = solve_linear(a, b, c, point - first - position);
  if (!change || !is_in_shape(CellShape::tetrahedron, from + *change)) return std::nullopt;
  return shape_weights(CellShape::tetrahedron, from + *change);
}

std::optional<CornerWeights> weights_in_cell(const CellGeometry& cell, Vec3d point) {
  if (cell.shape == CellShape::tetrahedron) {
    return weights_in_tetrahedron(
        {cell.corners[0], cell.corners[1], cell.corners[2], cell.corners[3]}, point);
  }
  const Vec3d first =
      cell.corners[0];  // positions are relative to it: large offsets cost no digits
  const Vec3d target = point - first;
  const auto count = static_cast<size_t>(cell.count());
  Vec3d at = centre(cell.shape);
  for (int32_t step = 0; step < kMostSteps; ++step) {
    const ShapeFunctions w = shape_functions(cell.shape, at);
    Vec3d position{0, 0, 0}, a{0, 0, 0}, b{0, 0, 0}, c{0, 0, 0};
    for (size_t i = 1; i < count; ++i) {
      const Vec3d corner = cell.corners[i] - first;
      position = position + corner * w.at[i];
      a = a + corner * w.slopes[i].x;
      b = b + corner * w.slopes[i].y;
      c = c + corner * w.slopes[i].z;
    }
    const auto change = solve_linear(a, b, c, target - position);
    if (!change) return std::nullopt;
    at = at + *change;
    const double moved = std::max({std::abs(change->x), std::abs(change->y), std::abs(change->z)});
    if (moved < kLastStep) {
      if (!is_in_shape(cell.shape, at)) return std::nullopt;
      return shape_weights(cell.shape, at);
    }
    if (!(std::max({std::abs(at.x), std::abs(at.y), std::abs(at.z)}) < kFar)) return std::nullopt;
  }
  return std::nullopt;
}

double volume_of(const CellGeometry& cell) {
  const Vec3d origin = cell.corners[0];
  double sum = 0;
  for (const CellFace& face : faces_of(cell.shape)) {
    const auto at = [&](size_t i) { return cell.corners[static_cast<size_t>(face[i])] - origin; };
    // A face of four corners is split along both diagonals, and the two volumes are averaged.
    if (face[3] < 0) {
      sum += dot(at(0), cross(at(1), at(2)));
      continue;
    }
    sum += (dot(at(0), cross(at(1), at(2))) + dot(at(0), cross(at(2), at(3))) +
            dot(at(0), cross(at(1), at(3))) + dot(at(1), cross(at(2), at(3)))) /
           2;
  }
  return std::abs(sum) / 6;
}

double size_of(const CellGeometry& cell) {
  constexpr double kShare[] = {6, 3, 2, 1};  // of the parallelepiped with the same edges
  double longest = 0;
  for (const CellFace& face : faces_of(cell.shape)) {
    const size_t count = face[3] < 0 ? 3 : 4;
    for (size_t i = 0; i < count; ++i) {
      const Vec3d edge = cell.corners[static_cast<size_t>(face[(i + 1) % count])] -
                         cell.corners[static_cast<size_t>(face[i])];
      longest = std::max(longest, dot(edge, edge));
    }
  }
  const double side = std::cbrt(volume_of(cell) * kShare[static_cast<size_t>(cell.shape)]);
  return std::max(side, std::sqrt(longest) / 4);
}

}  // namespace isosplat
