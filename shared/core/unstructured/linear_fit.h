#pragma once

#include <span>

#include "shared/core/base/vec3.h"

namespace isosplat {

struct SamplePoint {
  Vec3d at;
  double value = 0;
};

/// A linear function of the position: value + dot(slope, position).
struct LinearFunction {
  double value = 0;
  Vec3d slope{0, 0, 0};

  double operator()(Vec3d at) const { return value + dot(slope, at); }
};

/// The linear function with the least sum of squared differences. Requires points that do not lie
/// in a plane, with coordinates of about 1.
LinearFunction linear_fit(std::span<const SamplePoint> points);

}  // namespace isosplat
