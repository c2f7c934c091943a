#include "shared/core/sampling/exact_projection.h"

#include <algorithm>
#include <cmath>

namespace isosplat {
namespace {

/// a t³ + b t² + c t + d. In double precision, because its terms are not exact in single precision.
struct Cubic {
  double a, b, c, d;
  double operator()(double t) const { return ((a * t + b) * t + c) * t + d; }
  double derivative(double t) const { return (3 * a * t + 2 * b) * t + c; }
};

Cubic along_ray(const Trilinear& f, Vec3f o, Vec3f r, float isovalue) {
  const auto& k = f.coefficient;
  const double ox = o.x, oy = o.y, oz = o.z, rx = r.x, ry = r.y, rz = r.z;
  return {
      k[7] * rx * ry * rz,
      k[3] * rx * ry + k[5] * rx * rz + k[6] * ry * rz +
          k[7] * (ox * ry * rz + rx * oy * rz + rx * ry * oz),
      k[1] * rx + k[2] * ry + k[4] * rz + k[3] * (ox * ry + rx * oy) + k[5] * (ox * rz + rx * oz) +
          k[6] * (oy * rz + ry * oz) + k[7] * (ox * oy * rz + ox * ry * oz + rx * oy * oz),
      k[0] + k[1] * ox + k[2] * oy + k[4] * oz + k[3] * ox * oy + k[5] * ox * oz + k[6] * oy * oz +
          k[7] * ox * oy * oz - static_cast<double>(isovalue),
  };
}

/// The part of the ray inside the unit cell, as t₀ ≤ t₁; nothing if the ray misses the cell.
std::optional<std::pair<double, double>> clip_to_cell(Vec3f origin, Vec3f direction) {
  double t0 = -HUGE_VAL, t1 = HUGE_VAL;
  const float o[3] = {origin.x, origin.y, origin.z}, d[3] = {direction.x, direction.y, direction.z};
  for (int axis = 0; axis < 3; ++axis) {
    if (d[axis] == 0) {
      if (o[axis] < 0 || o[axis] > 1) return std::nullopt;
      continue;
    }
    double enter = (0.0 - o[axis]) / d[axis], leave = (1.0 - o[axis]) / d[axis];
    if (enter > leave) std::swap(enter, leave);
    t0 = std::max(t0, enter);
    t1 = std::min(t1, leave);
  }
  if (!(t0 <= t1) || !std::isfinite(t0) || !std::isfinite(t1)) return std::nullopt;
  return std::pair{t0, t1};
}

/// The root in [lo, hi], where the cubic is monotonic; nothing if its sign does not change. Uses
/// Newton's method, with bisection when a step leaves the bracket or does not halve the residual:
/// near an inflection the derivative vanishes, and Newton's method and regula falsi converge
/// slowly.
std::optional<double> bracketed_root(const Cubic& f, double lo, double hi) {
  const double f_lo = f(lo), f_hi = f(hi);
  if (f_lo == 0) return lo;
  if (f_hi == 0) return hi;
  if (!(f_lo < 0) == !(f_hi < 0)) return std::nullopt;
  const bool rising = f_lo < 0;
  const double tolerance = 1e-12 * std::max(std::abs(lo), std::abs(hi));
  double t = lo + (hi - lo) * (f_lo / (f_lo - f_hi)), previous = HUGE_VAL;
  for (int i = 0; i < 128; ++i) {
    const double f_t = f(t);
    if (f_t == 0) return t;
    ((f_t < 0) == rising ? lo : hi) = t;
    double next = t - f_t / f.derivative(t);
    if (!(next > lo && next < hi) || std::abs(f_t) > 0.5 * previous) next = 0.5 * (lo + hi);
    if (std::abs(next - t) <= tolerance) return next;
    previous = std::abs(f_t);
    t = next;
  }
  return t;
}

/// nearest_root_in_cell() in double precision.
std::optional<double> nearest_root(const Trilinear& f, Vec3f origin, Vec3f direction,
                                   float isovalue) {
  const auto inside = clip_to_cell(origin, direction);
  if (!inside) return std::nullopt;
  const RayRoots roots(f, origin, direction, isovalue, inside->first, inside->second);
  std::optional<double> nearest;
  for (const double root : roots.all()) {
    if (!nearest || std::abs(root) < std::abs(*nearest)) nearest = root;
  }
  return nearest;
}

}  // namespace

RayRoots::RayRoots(const Trilinear& f, Vec3f origin, Vec3f direction, float isovalue, double begin,
                   double end) {
  const Cubic cubic = along_ray(f, origin, direction, isovalue);

  // Between its extrema the cubic is monotonic: at most one root in each part.
  double bounds[4] = {begin, end, end, end};
  int parts = 1;
  const double a = 3 * cubic.a, b = 2 * cubic.b, c = cubic.c;
  const double discriminant = b * b - 4 * a * c;
  if (discriminant > 0) {
    const double q = -0.5 * (b + std::copysign(std::sqrt(discriminant), b));
    double extrema[2] = {a != 0 ? q / a : end, q != 0 ? c / q : end};
    if (extrema[0] > extrema[1]) std::swap(extrema[0], extrema[1]);
    for (const double t : extrema) {
      if (t > begin && t < end) bounds[parts++] = t;
    }
  }
  bounds[parts] = end;

  for (int i = 0; i < parts; ++i) {
    const auto root = bracketed_root(cubic, bounds[i], bounds[i + 1]);
    // Two parts share a root that is an extremum.
    if (root && (count_ == 0 || *root > t_[count_ - 1])) t_[count_++] = *root;
  }
}

std::optional<float> nearest_root_in_cell(const Trilinear& f, Vec3f origin, Vec3f direction,
                                          float isovalue) {
  const auto t = nearest_root(f, origin, direction, isovalue);
  if (!t) return std::nullopt;
  return static_cast<float>(*t);
}

std::optional<Vec3f> project_exactly(const Trilinear& f, Vec3f origin, Vec3f direction,
                                     float isovalue) {
  const auto t = nearest_root(f, origin, direction, isovalue);
  if (!t) return std::nullopt;
  // In double precision: a short direction makes t too large for a float.
  const auto at = [t](float o, float d) { return static_cast<float>(o + d * *t); };
  return Vec3f{at(origin.x, direction.x), at(origin.y, direction.y), at(origin.z, direction.z)};
}

}  // namespace isosplat
