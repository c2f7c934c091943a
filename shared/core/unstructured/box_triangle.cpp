#include "shared/core/unstructured/box_triangle.h"

#include <algorithm>
#include <cmath>

namespace isosplat {

bool overlap(const Box& box, const std::array<Vec3d, 3>& triangle) {
  const Vec3d centre = (box.low + box.high) * 0.5, half = (box.high - box.low) * 0.5;
  const Vec3d a = triangle[0] - centre, b = triangle[1] - centre, c = triangle[2] - centre;
  const auto is_apart = [&](Vec3d axis) {
    const double reach =
        half.x * std::abs(axis.x) + half.y * std::abs(axis.y) + half.z * std::abs(axis.z);
    const double x = dot(axis, a), y = dot(axis, b), z = dot(axis, c);
    return std::min({x, y, z}) > reach || std::max({x, y, z}) < -reach;
  };
  constexpr Vec3d kAxes[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (const Vec3d axis : kAxes) {
    if (is_apart(axis)) return false;
  }
  const Vec3d edges[] = {b - a, c - b, a - c};
  if (is_apart(cross(edges[0], edges[1]))) return false;
  for (const Vec3d edge : edges) {
    for (const Vec3d axis : kAxes) {
      if (is_apart(cross(edge, axis))) return false;
    }
  }
  return true;
}

}  // namespace isosplat
