#include "shared/core/select/visibility.h"

#include <algorithm>

#include "shared/core/select/block_id.h"

namespace isosplat {
namespace {

/// The ancestor of a block, `levels` levels coarser.
BlockKey ancestor(BlockKey block, uint32_t levels) {
  return {block.level + levels,
          {block.index.x >> levels, block.index.y >> levels, block.index.z >> levels}};
}

/// The index of a block among the blocks of its level that its ancestor contains.
Index3 index_in_ancestor(BlockKey block, uint32_t levels) {
  const int32_t mask = (1 << levels) - 1;
  return {block.index.x & mask, block.index.y & mask, block.index.z & mask};
}

}  // namespace

void VisibilityMap::clear() {
  tested_.clear();
  visible_.clear();
}

void VisibilityMap::add(BlockKey block, const RegionMask& tested, const RegionMask& visible) {
  tested_[block_id(block)] |= tested;
  // A region covers a block three levels finer. Below level 3 it is a part of a block of level 0.
  const uint32_t down = std::min(block.level, kRegionLevels);
  const uint32_t up = kRegionLevels - down;
  for (int32_t z = 0; z < kBlockRegions; ++z) {
    for (int32_t y = 0; y < kBlockRegions; ++y) {
      for (int32_t x = 0; x < kBlockRegions; ++x) {
        if (!visible.contains({x, y, z})) continue;
        BlockKey covered{block.level - down,
                         {((block.index.x << kRegionLevels) + x) >> up,
                          ((block.index.y << kRegionLevels) + y) >> up,
                          ((block.index.z << kRegionLevels) + z) >> up}};
        while (covered.level < kMaxLevels && visible_.insert(block_id(covered)).second) {
          covered = ancestor(covered, 1);
        }
      }
    }
  }
}

Visibility VisibilityMap::of(BlockKey block) const {
  if (visible_.contains(block_id(block))) return Visibility::visible;
  for (uint32_t levels = 0; block.level + levels < kMaxLevels; ++levels) {
    const auto found = tested_.find(block_id(ancestor(block, levels)));
    if (found == tested_.end()) continue;
    // A block smaller than a region has the result of the block that the region covers.
    const uint32_t levels_below_region = levels > kRegionLevels ? levels - kRegionLevels : 0;
    const BlockKey tested = ancestor(block, levels_below_region);
    RegionMask covered = RegionMask::of_block_below(
        index_in_ancestor(tested, levels - levels_below_region), levels - levels_below_region);
    covered &= found->second;
    if (!covered.any()) continue;
    return levels_below_region > 0 && visible_.contains(block_id(tested))
               ? Visibility::ancestor_visible
               : Visibility::hidden;
  }
  return Visibility::untested;
}

}  // namespace isosplat
