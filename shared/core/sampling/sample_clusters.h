#pragma once

#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

#include "shared/core/grid/region_mask.h"
#include "shared/core/sampling/packed_sample.h"

namespace isosplat {

/// The samples of one region of a chunk (8³ cells). They lie one after another, so that a region is
/// drawn or left out as a range of vertices. Decoding workers pass clusters to the renderer as
/// bytes.
struct SampleCluster {
  uint32_t first = 0;  ///< index of the first sample in the chunk
  uint32_t count = 0;
  CellInterval interval;  ///< of all samples: min of mins, max of maxes
  uint16_t region = 0;    ///< x + 8·y + 64·z in the block
  /// Half-open box of cells in the block that contains all samples.
  Vec3<uint8_t> low, high;

  Index3 region_index() const {
    return {region % kBlockRegions, region / kBlockRegions % kBlockRegions,
            region / (kBlockRegions * kBlockRegions)};
  }
};
static_assert(sizeof(SampleCluster) == 20 && std::is_trivially_copyable_v<SampleCluster>);

/// Sorts a chunk's samples by region into `ordered`, which is overwritten. Within a region they
/// keep their order. Returns a cluster for each region that has samples, in order of regions.
std::vector<SampleCluster> cluster_samples(std::span<const PackedSample> samples,
                                           std::vector<PackedSample>& ordered);

/// Whether clusters are as cluster_samples returns them: regions ascend, each cluster begins where
/// the one before ends, and its box lies in its region.
bool are_clusters(std::span<const SampleCluster> clusters);

}  // namespace isosplat
