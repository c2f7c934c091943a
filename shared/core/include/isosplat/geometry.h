#pragma once

/// \file
/// Vectors and matrices.

#include <array>
#include <cstdint>

namespace isosplat {

/// Three numbers: a point, a direction, or a size along x, y and z.
template <class T>
struct Vec3 {
  T x{};  ///< along the first axis
  T y{};  ///< along the second axis
  T z{};  ///< along the third axis

  /// Whether all three numbers are equal.
  friend constexpr bool operator==(const Vec3&, const Vec3&) = default;
  /// The sum.
  friend constexpr Vec3 operator+(Vec3 a, Vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  /// The difference.
  friend constexpr Vec3 operator-(Vec3 a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  /// Each number times s.
  friend constexpr Vec3 operator*(Vec3 a, T s) { return {a.x * s, a.y * s, a.z * s}; }
};

using Vec3f = Vec3<float>;     ///< in single precision
using Vec3d = Vec3<double>;    ///< in double precision
using Index3 = Vec3<int32_t>;  ///< an index or a size in a grid

/// A 3×3 matrix, row by row.
using Matrix3d = std::array<double, 9>;

/// The matrix that changes nothing.
inline constexpr Matrix3d kIdentity3{1, 0, 0, 0, 1, 0, 0, 0, 1};

}  // namespace isosplat
