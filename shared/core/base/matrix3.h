#pragma once

#include <algorithm>
#include <cmath>

#include "shared/core/base/vec3.h"

namespace isosplat {

constexpr Vec3d column(const Matrix3d& m, size_t index) {
  return {m[index], m[3 + index], m[6 + index]};
}

constexpr Vec3d multiply(const Matrix3d& m, Vec3d v) {
  return {m[0] * v.x + m[1] * v.y + m[2] * v.z, m[3] * v.x + m[4] * v.y + m[5] * v.z,
          m[6] * v.x + m[7] * v.y + m[8] * v.z};
}

/// The transposed matrix times v.
constexpr Vec3d multiply_transposed(const Matrix3d& m, Vec3d v) {
  return {dot(column(m, 0), v), dot(column(m, 1), v), dot(column(m, 2), v)};
}

/// The matrix with its columns multiplied by x, y and z.
constexpr Matrix3d scale_columns(const Matrix3d& m, Vec3d by) {
  return {m[0] * by.x, m[1] * by.y, m[2] * by.z, m[3] * by.x, m[4] * by.y,
          m[5] * by.z, m[6] * by.x, m[7] * by.y, m[8] * by.z};
}

constexpr double determinant(const Matrix3d& m) {
  return dot(column(m, 0), cross(column(m, 1), column(m, 2)));
}

/// The transposed inverse. The inverse times v is multiply_transposed(inverse_transpose(m), v).
/// Requires determinant(m) ≠ 0.
constexpr Matrix3d inverse_transpose(const Matrix3d& m) {
  const double det = determinant(m);
  const Vec3d a = cross(column(m, 1), column(m, 2)) * (1 / det);
  const Vec3d b = cross(column(m, 2), column(m, 0)) * (1 / det);
  const Vec3d c = cross(column(m, 0), column(m, 1)) * (1 / det);
  return {a.x, b.x, c.x, a.y, b.y, c.y, a.z, b.z, c.z};
}

/// The longest diagonal of the parallelepiped whose edges are the columns.
inline double longest_diagonal(const Matrix3d& edges) {
  const Vec3d a = column(edges, 0), b = column(edges, 1), c = column(edges, 2);
  return std::max({length(a + b + c), length(a + b - c), length(a - b + c), length(a - b - c)});
}

}  // namespace isosplat
