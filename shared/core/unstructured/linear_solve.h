#pragma once

#include <cmath>
#include <optional>

#include "shared/core/base/vec3.h"

namespace isosplat {

/// Solves a x + b y + c z = d by Cramer's rule. Nothing if the vectors lie in a plane.
inline std::optional<Vec3d> solve_linear(Vec3d a, Vec3d b, Vec3d c, Vec3d d) {
  const Vec3d bc = cross(b, c);
  const double share = 1 / dot(a, bc);
  const Vec3d found = Vec3d{dot(d, bc), dot(d, cross(c, a)), dot(d, cross(a, b))} * share;
  if (!std::isfinite(found.x) || !std::isfinite(found.y) || !std::isfinite(found.z)) {
    return std::nullopt;
  }
  return found;
}

}  // namespace isosplat
