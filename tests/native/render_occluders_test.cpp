// Grouping of samples into clusters, and which boxes are occluded by others.
#include <gtest/gtest.h>

#include <algorithm>

#include "shared/core/sampling/sample_clusters.h"
#include "shared/render/frame/occluders.h"

namespace isosplat::render {
namespace {

TEST(SampleClusters, HoldEachSampleOnceInTheRegionOfItsCell) {
  std::vector<PackedSample> samples, ordered;
  for (int32_t z = 0; z < 64; z += 3) {
    for (int32_t x = 0; x < 64; x += 5) {
      const auto quantized = static_cast<QuantizedValue>(10 * x + z);
      samples.push_back(
          pack_sample({x, (x + z) % 64, z}, {quantized, QuantizedValue(quantized + 7)}, {}));
    }
  }
  const auto clusters = cluster_samples(samples, ordered);
  ASSERT_EQ(ordered.size(), samples.size());
  uint32_t next = 0;
  for (const SampleCluster& cluster : clusters) {
    EXPECT_EQ(cluster.first, next);
    EXPECT_GT(cluster.count, 0u);
    next += cluster.count;
    CellInterval interval{kMissingVoxel, 0};
    Index3 low{63, 63, 63}, high{0, 0, 0};
    for (uint32_t i = cluster.first; i < next; ++i) {
      EXPECT_NE(std::find(samples.begin(), samples.end(), ordered[i]), samples.end());
      const UnpackedSample sample = unpack_sample(ordered[i]);
      const Index3 at = sample.cell, region = cluster.region_index();
      EXPECT_EQ((Index3{at.x / 8, at.y / 8, at.z / 8}), region);
      low = {std::min(low.x, at.x), std::min(low.y, at.y), std::min(low.z, at.z)};
      high = {std::max(high.x, at.x + 1), std::max(high.y, at.y + 1), std::max(high.z, at.z + 1)};
      interval.min = std::min(interval.min, sample.interval.min);
      interval.max = std::max(interval.max, sample.interval.max);
    }
    EXPECT_EQ((Index3{cluster.low.x, cluster.low.y, cluster.low.z}), low);
    EXPECT_EQ((Index3{cluster.high.x, cluster.high.y, cluster.high.z}), high);
    EXPECT_EQ(cluster.interval, interval);
  }
  EXPECT_EQ(next, samples.size());
}

TEST(SampleClusters, AreRecognisedByTheirOrder) {
  std::vector<PackedSample> samples, ordered;
  for (int32_t x = 0; x < 64; ++x) samples.push_back(pack_sample({x, x, x}, {1, 2}, {}));
  const auto clusters = cluster_samples(samples, ordered);
  ASSERT_EQ(clusters.size(), 8u);
  EXPECT_TRUE(are_clusters(clusters));
  EXPECT_TRUE(are_clusters({}));
  const auto changed = [&](auto change) {
    auto copy = clusters;
    change(copy);
    return are_clusters(copy);
  };
  EXPECT_FALSE(changed([](auto& c) { c[3].first += 1; }));
  EXPECT_FALSE(changed([](auto& c) { c[3].count -= 1; }));
  EXPECT_FALSE(changed([](auto& c) { c.erase(c.begin()); }));
  EXPECT_FALSE(changed([](auto& c) { c[3].region = c[2].region; }));
  EXPECT_FALSE(changed([](auto& c) { c[7].region = 512; }));
  EXPECT_FALSE(changed([](auto& c) { c[3].high.z += 1; }));
  EXPECT_FALSE(changed([](auto& c) { c[3].low.x -= 1; }));
  EXPECT_FALSE(changed([](auto& c) { c[3].high.y = c[3].low.y; }));
  EXPECT_FALSE(changed([](auto& c) { c[7].high.x = 255; }));
  EXPECT_FALSE(changed([](auto& c) { c.push_back({64, 0, {1, 2}, 511, {}, {}}); }));
}

/// A view along z with 256² pixels; at a distance of 256, a pixel is 1 wide.
FrameBlock frame_along_z() {
  FrameBlock frame{};
  frame.right = {1, 0, 0, 0};
  frame.up = {0, 1, 0, 0};
  frame.forward = {0, 0, 1, 0};
  frame.near_plane = 1;
  frame.far_plane = 1000;
  frame.image_size = {256, 256};
  frame.image_middle = {128, 128};
  frame.focal_px = 256;
  return frame;
}

TEST(Occluders, HideOnlyBoxesBehindThem) {
  Occluders occluders;
  occluders.begin(frame_along_z());
  const Occluders::Box behind{{0, 0, 200}, {4, 4, 4}};
  EXPECT_FALSE(occluders.occlude(behind));
  occluders.add({{0, 0, 100}, {10, 10, 2}}, 400);
  EXPECT_TRUE(occluders.occlude(behind));
  EXPECT_FALSE(occluders.occlude({{0, 0, 100}, {4, 4, 2}}));   // beside it, in part before it
  EXPECT_FALSE(occluders.occlude({{0, 0, 50}, {1, 1, 1}}));    // before it
  EXPECT_FALSE(occluders.occlude({{20, 0, 200}, {8, 4, 4}}));  // in part beside it
  occluders.begin(frame_along_z());
  EXPECT_FALSE(occluders.occlude(behind));
}

TEST(Occluders, HideByTheirAreaOnly) {
  Occluders occluders;
  occluders.begin(frame_along_z());
  occluders.add({{0, 0, 100}, {10, 10, 2}}, 4);
  EXPECT_FALSE(occluders.occlude({{0, 0, 200}, {4, 4, 4}}));
}

TEST(Occluders, TestWhetherABoxIsInTheImage) {
  Occluders occluders;
  occluders.begin(frame_along_z());
  EXPECT_TRUE(occluders.is_in_image({{60, 0, 100}, {15, 1, 1}}, 0));
  EXPECT_FALSE(occluders.is_in_image({{70, 0, 100}, {15, 1, 1}}, 0));
  EXPECT_TRUE(occluders.is_in_image({{70, 0, 100}, {15, 1, 1}}, 64));
  EXPECT_TRUE(occluders.is_in_image({{70, 0, 0}, {15, 1, 1}}, 0));  // around the near plane
}

}  // namespace
}  // namespace isosplat::render
