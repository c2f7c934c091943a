#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <random>

#include "native/builder/array_source.h"
#include "native/builder/distance_source.h"
#include "native/builder/signed_distance.h"

namespace isosplat {
namespace {

/// The distance of a voxel's centre from the box of another.
double distance_to_box(Index3 from, Index3 to, Vec3d spacing) {
  const auto along = [](int32_t a, int32_t b, double edge) {
    return std::max(std::abs(a - b) - 0.5, 0.0) * edge;
  };
  return length(Vec3d{along(from.x, to.x, spacing.x), along(from.y, to.y, spacing.y),
                      along(from.z, to.z, spacing.z)});
}

/// By comparing each voxel with each other.
std::vector<double> brute_force(Index3 size, Vec3d spacing, const std::vector<float>& sides) {
  std::vector<Index3> voxels;
  for (int32_t z = 0; z < size.z; ++z) {
    for (int32_t y = 0; y < size.y; ++y) {
      for (int32_t x = 0; x < size.x; ++x) voxels.push_back({x, y, z});
    }
  }
  std::vector<double> distances;
  for (size_t i = 0; i < voxels.size(); ++i) {
    double nearest = std::numeric_limits<double>::infinity();
    for (size_t j = 0; j < voxels.size(); ++j) {
      if (sides[j] == sides[i]) continue;
      nearest = std::min(nearest, distance_to_box(voxels[i], voxels[j], spacing));
    }
    distances.push_back(sides[i] == kInside ? -nearest : nearest);
  }
  return distances;
}

TEST(BuildDistance, EqualsComparingAllVoxels) {
  std::mt19937 random(7);
  // Few, many and half of the voxels inside; unequal edges; very small and large units.
  for (const double share : {0.003, 0.5, 0.997}) {
    for (const Vec3d spacing : {Vec3d{1, 1, 1}, Vec3d{0.7, 1.3, 3}, Vec3d{5e-30, 2e-30, 1e-30},
                                Vec3d{1e25, 1e25, 4e25}}) {
      const Index3 size{13, 9, 11};
      std::vector<float> voxels(13 * 9 * 11);
      std::bernoulli_distribution is_inside(share);
      for (float& voxel : voxels) voxel = is_inside(random) ? kInside : kOutside;
      voxels.front() = kInside;
      voxels.back() = kOutside;
      const auto expected = brute_force(size, spacing, voxels);
      signed_distances(size, spacing, voxels);
      for (size_t i = 0; i < voxels.size(); ++i) {
        ASSERT_NEAR(voxels[i], expected[i], 1e-6 * std::abs(expected[i])) << share << ' ' << i;
      }
    }
  }
}

TEST(BuildDistance, IsZeroOnFacesBetweenVoxels) {
  std::vector<float> row{kOutside, kOutside, kInside, kInside, kInside, kOutside};
  signed_distances({6, 1, 1}, {2, 1, 1}, row);
  EXPECT_EQ(row, (std::vector<float>{3, 1, -1, -3, -1, 1}));
}

TEST(BuildDistance, OneSideAloneHasNoBorder) {
  std::vector<float> voxels(8, kInside);
  signed_distances({2, 2, 2}, {1, 1, 1}, voxels);
  for (const float voxel : voxels) {
    EXPECT_EQ(voxel, -std::numeric_limits<float>::infinity());
  }
}

std::unique_ptr<VolumeSource> labels(std::vector<float> voxels,
                                     Matrix3d direction = {1, 0, 0, 0, 1, 0, 0, 0, 1}) {
  VolumeGrid grid;
  grid.voxels = {4, 2, 2};
  grid.direction = direction;
  return std::make_unique<ArraySource<float>>(grid, std::move(voxels));
}

const std::vector<float> kLabels{0, 3, 5, 0, 0, 3, 5, 0, 0, 3, 5, 0, 0, 3, 5, 0};

Result<std::vector<float>> distances(std::unique_ptr<VolumeSource> volume,
                                     std::vector<int64_t> chosen, uint64_t memory = 1 << 20) {
  const VolumeGrid grid = volume->header().grid;
  auto source = DistanceSource::create("d", std::move(volume), grid, std::move(chosen), memory);
  if (!source) return tl::unexpected(source.error());
  std::vector<float> values(16);
  const auto bytes = std::as_writable_bytes(std::span(values));
  // In two parts: the second does not compute them again.
  for (const int32_t z : {0, 1}) {
    auto read = (*source)->read_slices(z, 1, bytes.subspan(32 * static_cast<size_t>(z), 32));
    if (!read) return tl::unexpected(read.error());
  }
  return values;
}

TEST(BuildDistance, OfAllLabelsOrOfThoseThatAreNamed) {
  const auto all = distances(labels(kLabels), {});
  ASSERT_TRUE(all) << all.error().message;
  EXPECT_EQ(std::vector<float>(all->begin(), all->begin() + 4),
            (std::vector<float>{0.5, -0.5, -0.5, 0.5}));
  const auto one = distances(labels(kLabels), {5});
  EXPECT_EQ(std::vector<float>(one->begin() + 12, one->end()),
            (std::vector<float>{1.5, 0.5, -0.5, 0.5}));
  EXPECT_EQ(*distances(labels(kLabels), {5, 3}), *all);
}

TEST(BuildDistance, VoxelsWithoutAValueHaveNoLabel) {
  using Limits = std::numeric_limits<float>;
  for (const float none : {Limits::quiet_NaN(), Limits::infinity(), -Limits::infinity()}) {
    std::vector<float> voxels = kLabels;
    for (float& voxel : voxels) {
      if (voxel == 0) voxel = none;
    }
    EXPECT_EQ(*distances(labels(voxels), {}), *distances(labels(kLabels), {})) << none;
  }
}

TEST(BuildDistance, RefusesWhatHasNoBorder) {
  const auto expect = [](const Result<std::vector<float>>& found, Status status,
                         const std::string& text) {
    ASSERT_FALSE(found);
    EXPECT_EQ(found.error().status, status);
    EXPECT_NE(found.error().message.find(text), std::string::npos) << found.error().message;
  };
  expect(distances(labels(kLabels), {4}), Status::malformed_volume, "without");
  expect(distances(labels(std::vector<float>(16, 1)), {}), Status::malformed_volume, "with them");
  expect(distances(labels(std::vector<float>(16, 0.5)), {}), Status::malformed_volume, "0.5");
  // Beyond 2^53, numbers of double precision do not tell labels apart.
  expect(distances(labels(std::vector<float>(16, -0x1p54f)), {}), Status::malformed_volume, "2^53");
  expect(distances(labels(kLabels, {1, 0.6, 0, 0, 0.8, 0, 0, 0, 1}), {}),
         Status::unsupported_format, "right angles");
  expect(distances(labels(kLabels), {}, 50), Status::out_of_memory, "--memory");
}

}  // namespace
}  // namespace isosplat
