#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "shared/grid/region_mask.h"
#include "shared/sampling/packed_sample.h"

namespace isosplat {

/// The samples of one region of a chunk (8³ cells), which lie one after another: what is drawn or
/// left out together.
struct SampleCluster {
  uint32_t first = 0;  ///< among the chunk's samples
  uint32_t count = 0;
  CellInterval interval;  ///< of all samples: min of mins, max of maxes
  uint16_t region = 0;    ///< x + 8·y + 64·z in the block
  /// Cells of the block that hold all samples: from low, up to and without high.
  Vec3<uint8_t> low, high;

  Index3 region_index() const {
    return {region % kBlockRegions, region / kBlockRegions % kBlockRegions,
            region / (kBlockRegions * kBlockRegions)};
  }
};

/// Puts a chunk's samples in the order of their regions into `ordered`, which is overwritten, and
/// answers the regions that have any. Inside of a region they keep their order.
std::vector<SampleCluster> cluster_samples(std::span<const PackedSample> samples,
                                           std::vector<PackedSample>& ordered);

}  // namespace isosplat
