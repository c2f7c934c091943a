#include "shared/core/unstructured/linear_fit.h"

#include "shared/core/unstructured/linear_solve.h"

namespace isosplat {

LinearFunction linear_fit(std::span<const SamplePoint> points) {
  const double share = 1 / static_cast<double>(points.size());
  Vec3d mean{0, 0, 0};
  double value = 0;
  for (const SamplePoint& point : points) {
    mean = mean + point.at * share;
    value += point.value * share;
  }
  // The normal equations of the differences to the means: a symmetric matrix, by columns.
  Vec3d x{0, 0, 0}, y{0, 0, 0}, z{0, 0, 0}, right{0, 0, 0};
  for (const SamplePoint& point : points) {
    const Vec3d d = point.at - mean;
    x = x + d * d.x;
    y = y + d * d.y;
    z = z + d * d.z;
    right = right + d * (point.value - value);
  }
  const auto slope = solve_linear(x, y, z, right);
  if (!slope) return {value, {0, 0, 0}};
  return {value - dot(*slope, mean), *slope};
}

}  // namespace isosplat
