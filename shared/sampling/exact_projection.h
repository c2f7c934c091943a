#pragma once

#include <optional>

#include "shared/sampling/trilinear.h"

namespace isosplat {

/// Where a ray meets the isosurface of one cell: the root t of f(p + t·d) = isovalue that is
/// nearest to t = 0 among those with p + t·d inside the unit cell (paper, section 3.1, equations 2
/// and 3). Along a ray the trilinear interpolant is a cubic in t; its roots are bracketed between
/// its extrema and refined there, which stays exact where Cardan's formula cancels.
///
/// `origin` and `direction` are in cell units. Returns nothing where the ray meets no isosurface
/// inside the cell, or the direction is zero: the caller then keeps the approximate projection, or
/// drops the sample.
std::optional<float> nearest_root_in_cell(const Trilinear& f, Vec3f origin, Vec3f direction,
                                          float isovalue);

/// The exact projection of a point along a gradient, in cell units. `direction` is the world
/// gradient's direction expressed in cell units. Nothing where nearest_root_in_cell finds nothing.
std::optional<Vec3f> project_exactly(const Trilinear& f, Vec3f origin, Vec3f direction,
                                     float isovalue);

}  // namespace isosplat
