#pragma once

#include <optional>

#include "shared/base/vec3.h"

namespace isosplat {

/// The approximate projection of a point onto the isosurface: one Newton step along the gradient,
/// p' = p + ∇f · (isovalue − f) / (∇f · ∇f) (paper, equations 5 and 6).
///
/// All arguments in one frame: `gradient` is with respect to the space of `position`, and the
/// gradient's values are in the units of `value` and `isovalue`. The frame must have the volume's
/// proportions (world, or spacing-scaled index space), else the step is not along the normal.
///
/// Returns nothing where the gradient is zero: there is no direction to go.
inline std::optional<Vec3f> project(Vec3f position, float value, Vec3f gradient, float isovalue) {
  const float squared = dot(gradient, gradient);
  if (!(squared > 0)) return std::nullopt;
  return position + gradient * ((isovalue - value) / squared);
}

/// Δd = ½ √(sx² + sy² + sz²): a sample projected further than this from its cell's centre is not
/// drawn (paper, section 3.2, figure 3). `cell_size` in the units of the projection.
inline float displacement_threshold(Vec3f cell_size) {
  return 0.5f * length(cell_size);
}

}  // namespace isosplat
