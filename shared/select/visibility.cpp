#include "shared/select/visibility.h"

#include <algorithm>

#include "shared/select/block_id.h"

namespace isosplat {
namespace {

/// The block `levels` levels above.
BlockKey above(BlockKey block, uint32_t levels) {
  return {block.level + levels,
          {block.index.x >> levels, block.index.y >> levels, block.index.z >> levels}};
}

/// Where the block lies in that `levels` levels above it.
Index3 place_in_above(BlockKey block, uint32_t levels) {
  const int32_t mask = (1 << levels) - 1;
  return {block.index.x & mask, block.index.y & mask, block.index.z & mask};
}

}  // namespace

void VisibilityMap::clear() {
  tested_.clear();
  seen_.clear();
}

void VisibilityMap::add(BlockKey block, const RegionMask& tested, const RegionMask& seen) {
  tested_[block_id(block)] |= tested;
  // A region of a block below level 3 is a part of a block of level 0.
  const uint32_t down = std::min(block.level, kRegionLevels);
  const uint32_t up = kRegionLevels - down;
  for (int32_t z = 0; z < kBlockRegions; ++z) {
    for (int32_t y = 0; y < kBlockRegions; ++y) {
      for (int32_t x = 0; x < kBlockRegions; ++x) {
        if (!seen.contains({x, y, z})) continue;
        BlockKey below{block.level - down,
                       {((block.index.x << kRegionLevels) + x) >> up,
                        ((block.index.y << kRegionLevels) + y) >> up,
                        ((block.index.z << kRegionLevels) + z) >> up}};
        while (below.level < kMaxLevels && seen_.insert(block_id(below)).second) {
          below = above(below, 1);
        }
      }
    }
  }
}

Visibility VisibilityMap::of(BlockKey block) const {
  if (seen_.contains(block_id(block))) return Visibility::seen;
  for (uint32_t levels = 0; block.level + levels < kMaxLevels; ++levels) {
    const auto found = tested_.find(block_id(above(block, levels)));
    if (found == tested_.end()) continue;
    // Deeper than a region is known as well as the region.
    const uint32_t deeper = levels > kRegionLevels ? levels - kRegionLevels : 0;
    const BlockKey known = above(block, deeper);
    RegionMask covered =
        RegionMask::of_block_below(place_in_above(known, levels - deeper), levels - deeper);
    covered &= found->second;
    if (!covered.any()) continue;
    return deeper > 0 && seen_.contains(block_id(known)) ? Visibility::coarse : Visibility::hidden;
  }
  return Visibility::unknown;
}

}  // namespace isosplat
