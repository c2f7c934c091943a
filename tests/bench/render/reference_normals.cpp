#include "tests/bench/render/reference_normals.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace isosplat {
namespace {

constexpr double kDegrees = 180 / 3.14159265358979323846;

/// Central differences at a voxel, one-sided at the ends of the volume; per voxel.
Vec3d central_difference(const TestVolume& volume, Index3 v) {
  const auto along = [&](int axis) {
    const auto at = [&](int32_t step) {
      int32_t i[3] = {v.x, v.y, v.z};
      const int32_t size[3] = {volume.grid.voxels.x, volume.grid.voxels.y, volume.grid.voxels.z};
      i[axis] = std::clamp(i[axis] + step, 0, size[axis] - 1);
      return std::pair{i[axis], double(volume.at(i[0], i[1], i[2]))};
    };
    const auto [low, below] = at(-1);
    const auto [high, above] = at(1);
    return (above - below) / (high - low);
  };
  return {along(0), along(1), along(2)};
}

}  // namespace

double angle(Vec3d a, Vec3d b) {
  return std::atan2(length(cross(a, b)), dot(a, b)) * kDegrees;
}

Vec3d reference_gradient(const TestVolume& volume, Vec3d p) {
  const Index3 n = volume.grid.voxels;
  const auto low = [](double x, int32_t size) {
    return std::clamp(static_cast<int32_t>(std::floor(x)), 0, size - 2);
  };
  const Index3 cell{low(p.x, n.x), low(p.y, n.y), low(p.z, n.z)};
  Vec3d sum;
  for (int i = 0; i < 8; ++i) {
    const Index3 v{cell.x + (i & 1), cell.y + (i >> 1 & 1), cell.z + (i >> 2)};
    const double weight =
        (1 - std::abs(p.x - v.x)) * (1 - std::abs(p.y - v.y)) * (1 - std::abs(p.z - v.z));
    sum = sum + central_difference(volume, v) * weight;
  }
  return volume.grid.world_gradient(sum);
}

double percentile(std::vector<double>& values, double share) {
  if (values.empty()) return 0;
  const auto at = values.begin() + static_cast<ptrdiff_t>(share * double(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

}  // namespace isosplat
