#pragma once

#include <optional>

#include "isosplat/points.h"
#include "shared/core/base/matrix3.h"
#include "shared/core/base/vec3.h"

namespace isosplat {

/// The approximate projection of a point onto the isosurface: one Newton step along the gradient,
/// p' = p + ∇f · (isovalue − f) / (∇f · ∇f) (paper, equations 5 and 6).
///
/// All arguments are in one coordinate frame: `gradient` is with respect to the space of
/// `position`, and the gradient's values are in the units of `value` and `isovalue`. Lengths and
/// angles of the frame must be those of the world, else the step is not along the normal.
///
/// Returns nothing if the gradient is zero.
inline std::optional<Vec3f> project(Vec3f position, float value, Vec3f gradient, float isovalue) {
  const float squared = dot(gradient, gradient);
  if (!(squared > 0)) return std::nullopt;
  return position + gradient * ((isovalue - value) / squared);
}

/// Δd, the displacement threshold: half the longest diagonal of the cell with these edges (the
/// columns), ½ √(sx² + sy² + sz²) where they are perpendicular (paper, section 3.2, figure 3). No
/// point of the cell is further from its centre, however the cell is sheared.
inline double displacement_threshold(const Matrix3d& cell_edges) {
  return 0.5 * longest_diagonal(cell_edges);
}

}  // namespace isosplat
