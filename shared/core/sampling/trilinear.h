#pragma once

#include "shared/core/base/vec3.h"
#include "shared/core/sampling/cell.h"

namespace isosplat {

/// A value and its gradient with respect to position in the cell, in quantized values per cell.
struct ValueAndGradient {
  float value = 0;
  Vec3f gradient;
};

/// The trilinear interpolant of a cell, as its eight polynomial coefficients (paper, section 3):
/// f(x, y, z) = Σ coefficient[i + 2j + 4k] x^i y^j z^k, with 0 ≤ x, y, z ≤ 1 inside the cell.
struct Trilinear {
  std::array<float, 8> coefficient;

  explicit Trilinear(const std::array<float, 8>& corner) : coefficient(corner) {
    for (int axis = 1; axis < 8; axis *= 2) {
      for (int i = 0; i < 8; ++i) {
        if (i & axis) coefficient[i] -= coefficient[i - axis];
      }
    }
  }

  explicit Trilinear(const CellCorners& corners) : Trilinear(as_floats(corners)) {}

  /// Value and gradient at p, together: they share the interpolation along z.
  ValueAndGradient at(Vec3f p) const {
    const auto& c = coefficient;
    const float c0 = c[0] + p.z * c[4], c1 = c[1] + p.z * c[5];
    const float c2 = c[2] + p.z * c[6], c3 = c[3] + p.z * c[7];
    const float dz = c[4] + p.x * c[5] + p.y * (c[6] + p.x * c[7]);
    return {c0 + p.x * c1 + p.y * (c2 + p.x * c3), {c1 + p.y * c3, c2 + p.x * c3, dz}};
  }

  static std::array<float, 8> as_floats(const CellCorners& corners) {
    std::array<float, 8> result;
    for (int i = 0; i < 8; ++i) result[i] = static_cast<float>(corners[i]);
    return result;
  }
};

}  // namespace isosplat
