#include "shared/core/sampling/sample_clusters.h"

#include <algorithm>
#include <array>
#include <limits>

namespace isosplat {
namespace {

constexpr uint32_t kRegions = kBlockRegions * kBlockRegions * kBlockRegions;

/// From the bits of packed_sample.h: the upper three of the six bits of each coordinate.
uint32_t region_of(const PackedSample& sample) {
  const uint32_t cell = sample.word[0];
  return (cell >> 3 & 7) | (cell >> 9 & 7) << 3 | (cell >> 15 & 7) << 6;
}

void include(SampleCluster& cluster, const PackedSample& sample) {
  const auto coordinate = [&](int shift) {
    return static_cast<uint8_t>(sample.word[0] >> shift & 63);
  };
  const Vec3<uint8_t> at{coordinate(0), coordinate(6), coordinate(12)};
  const auto beyond = [](uint8_t a, uint8_t b) { return std::max(a, static_cast<uint8_t>(b + 1)); };
  cluster.low = {std::min(cluster.low.x, at.x), std::min(cluster.low.y, at.y),
                 std::min(cluster.low.z, at.z)};
  cluster.high = {beyond(cluster.high.x, at.x), beyond(cluster.high.y, at.y),
                  beyond(cluster.high.z, at.z)};
  cluster.interval.min =
      std::min(cluster.interval.min, static_cast<QuantizedValue>(sample.word[1] & 0xffff));
  cluster.interval.max =
      std::max(cluster.interval.max, static_cast<QuantizedValue>(sample.word[1] >> 16));
}

}  // namespace

std::vector<SampleCluster> cluster_samples(std::span<const PackedSample> samples,
                                           std::vector<PackedSample>& ordered) {
  std::array<uint32_t, kRegions> counts{};
  for (const PackedSample& sample : samples) ++counts[region_of(sample)];
  std::vector<SampleCluster> clusters;
  std::array<uint16_t, kRegions> cluster_of{};
  uint32_t first = 0;
  for (uint32_t region = 0; region < kRegions; ++region) {
    if (counts[region] == 0) continue;
    cluster_of[region] = static_cast<uint16_t>(clusters.size());
    clusters.push_back(
        {first, 0, {kMissingVoxel, 0}, static_cast<uint16_t>(region), {63, 63, 63}, {0, 0, 0}});
    first += counts[region];
  }
  ordered.resize(samples.size());
  for (const PackedSample& sample : samples) {
    SampleCluster& cluster = clusters[cluster_of[region_of(sample)]];
    include(cluster, sample);
    ordered[cluster.first + cluster.count++] = sample;
  }
  return clusters;
}

namespace {

/// Whether the cluster's box has cells, and lies in the cluster's region.
bool has_box_in_region(const SampleCluster& cluster) {
  constexpr int32_t kCells = kBlockCells / kBlockRegions;
  const Index3 region = cluster.region_index();
  const auto is_inside = [](int32_t at, uint8_t low, uint8_t high) {
    return at * kCells <= low && low < high && high <= (at + 1) * kCells;
  };
  return is_inside(region.x, cluster.low.x, cluster.high.x) &&
         is_inside(region.y, cluster.low.y, cluster.high.y) &&
         is_inside(region.z, cluster.low.z, cluster.high.z);
}

}  // namespace

bool are_clusters(std::span<const SampleCluster> clusters) {
  uint64_t first = 0;
  uint32_t next_region = 0;
  for (const SampleCluster& cluster : clusters) {
    if (cluster.first != first || cluster.count == 0 || cluster.region < next_region ||
        !has_box_in_region(cluster)) {
      return false;
    }
    first += cluster.count;
    next_region = uint32_t{cluster.region} + 1;
  }
  return next_region <= kRegions && first <= std::numeric_limits<uint32_t>::max();
}

}  // namespace isosplat
