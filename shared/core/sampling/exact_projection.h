#pragma once

#include <array>
#include <optional>
#include <span>

#include "shared/core/sampling/trilinear.h"

namespace isosplat {

/// The intersections of a ray with the isosurface of a cell's function: the roots t of
/// f(p + t·d) = isovalue with begin ≤ t ≤ end, ascending. Along a ray the trilinear interpolant is
/// a cubic in t; its roots are bracketed between its extrema and refined there, which avoids the
/// cancellation in Cardan's formula. Does not test whether the points are in the cell.
class RayRoots {
 public:
  RayRoots(const Trilinear& f, Vec3f origin, Vec3f direction, float isovalue, double begin,
           double end);

  std::span<const double> all() && = delete;
  std::span<const double> all() const& { return {t_.data(), count_}; }

 private:
  std::array<double, 3> t_{};
  size_t count_ = 0;
};

/// The intersection of a ray with the isosurface in one cell: the root t of f(p + t·d) = isovalue
/// that is nearest to t = 0 among those with p + t·d inside the unit cell (paper, section 3.1,
/// equations 2 and 3).
///
/// `origin` and `direction` are in cell units. Returns nothing if the ray does not intersect
/// the isosurface inside the cell, or if the direction is zero. The caller then keeps the
/// approximate projection, or drops the sample.
std::optional<float> nearest_root_in_cell(const Trilinear& f, Vec3f origin, Vec3f direction,
                                          float isovalue);

/// The exact projection of a point along a gradient, in cell units. `direction` is the world
/// gradient's direction expressed in cell units. Returns nothing if there is no root in the cell.
std::optional<Vec3f> project_exactly(const Trilinear& f, Vec3f origin, Vec3f direction,
                                     float isovalue);

}  // namespace isosplat
