#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "native/builder/array_source.h"
#include "native/builder/derived_source.h"

namespace isosplat {
namespace {

constexpr Index3 kSize{30, 26, 22};

VolumeGrid sheared_grid() {
  VolumeGrid grid;
  grid.voxels = kSize;
  grid.spacing = {0.5, 0.75, 0.6};
  grid.origin = {-7, -9, -6};
  const double tilt = std::sqrt(0.5);
  grid.direction = {0, -1, 0, 1, 0, tilt, 0, 0, tilt};
  return grid;
}

/// 3 · (5 − the distance from a point), whose isosurfaces are spheres.
std::vector<float> ball(const VolumeGrid& grid, Vec3d centre) {
  std::vector<float> voxels;
  for (int32_t z = 0; z < grid.voxels.z; ++z) {
    for (int32_t y = 0; y < grid.voxels.y; ++y) {
      for (int32_t x = 0; x < grid.voxels.x; ++x) {
        const Vec3d at = grid.world({1.0 * x, 1.0 * y, 1.0 * z});
        voxels.push_back(static_cast<float>(3 * (5 - length(at - centre))));
      }
    }
  }
  return voxels;
}

std::vector<double> derive(const VolumeGrid& grid, const std::vector<float>& voxels,
                           Derived derived) {
  DerivedSource source(std::make_unique<ArraySource<float>>(grid, voxels), derived);
  std::vector<double> values(voxels.size());
  const size_t slice = static_cast<size_t>(grid.voxels.x) * static_cast<size_t>(grid.voxels.y);
  for (int32_t z = 0; z < grid.voxels.z; z += 3) {
    const int32_t slices = std::min(3, grid.voxels.z - z);
    const auto read = source.read_slices(
        z, slices,
        std::as_writable_bytes(std::span(values).subspan(slice * static_cast<size_t>(z),
                                                         slice * static_cast<size_t>(slices))));
    EXPECT_TRUE(read) << read.error().message;
  }
  return values;
}

TEST(BuildDerived, GradientAndCurvatureOfSpheresOnASkewedGrid) {
  const VolumeGrid grid = sheared_grid();
  const Vec3d centre = grid.world({14.3, 12.6, 10.2});
  const auto voxels = ball(grid, centre);
  const auto gradient = derive(grid, voxels, Derived::gradient);
  const auto curvature = derive(grid, voxels, Derived::curvature);
  size_t i = 0, compared = 0;
  for (int32_t z = 0; z < grid.voxels.z; ++z) {
    for (int32_t y = 0; y < grid.voxels.y; ++y) {
      for (int32_t x = 0; x < grid.voxels.x; ++x, ++i) {
        ASSERT_TRUE(std::isfinite(gradient[i]) && std::isfinite(curvature[i]));
        ASSERT_LE(std::abs(curvature[i]), 2.0);
        const double radius = length(grid.world({1.0 * x, 1.0 * y, 1.0 * z}) - centre);
        const bool is_inside = x > 0 && y > 0 && z > 0 && x < kSize.x - 1 && y < kSize.y - 1 &&
                               z < kSize.z - 1 && radius > 4;
        if (!is_inside) continue;
        ASSERT_NEAR(gradient[i], 3, 0.05) << radius;
        ASSERT_NEAR(curvature[i] * radius, 1, 0.05) << radius;
        ++compared;
      }
    }
  }
  EXPECT_GT(compared, 1000u);
}

TEST(BuildDerived, CurvatureIsNegativeAroundSmallerValues) {
  const VolumeGrid grid = sheared_grid();
  auto voxels = ball(grid, grid.world({14.3, 12.6, 10.2}));
  for (float& voxel : voxels) voxel = -voxel;
  EXPECT_LT(derive(grid, voxels, Derived::curvature)[(size_t{10} * 26 + 12) * 30 + 24], 0);
}

TEST(BuildDerived, HasNoValueBesideMissingVoxelsAndNoCurvatureOfPlateaus) {
  VolumeGrid grid;
  grid.voxels = {9, 8, 9};
  std::vector<float> voxels(9 * 8 * 9, 2.0f);
  for (const double value : derive(grid, voxels, Derived::gradient)) EXPECT_EQ(value, 0);
  for (const double value : derive(grid, voxels, Derived::curvature))
    EXPECT_TRUE(std::isnan(value));
  voxels[(size_t{4} * 8 + 3) * 9 + 4] = std::numeric_limits<float>::infinity();
  const auto values = derive(grid, voxels, Derived::gradient);
  EXPECT_EQ(std::count_if(values.begin(), values.end(), [](double v) { return std::isnan(v); }), 6);
}

TEST(BuildDerived, TwoVoxelsAlongAnAxisHaveOneDifference) {
  VolumeGrid grid;
  grid.voxels = {2, 2, 2};
  grid.spacing = {2, 1, 1};
  const std::vector<float> voxels{0, 4, 0, 4, 0, 4, 0, 4};
  for (const double value : derive(grid, voxels, Derived::gradient)) EXPECT_EQ(value, 2);
  for (const double value : derive(grid, voxels, Derived::curvature)) EXPECT_EQ(value, 0);
}

}  // namespace
}  // namespace isosplat
