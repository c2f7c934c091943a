#pragma once

#include <cstdint>

#include "shared/core/grid/grid.h"

namespace isosplat {

/// 2^20 voxels along an axis need 16 halvings to reach kCoarsestCells.
inline constexpr uint32_t kMaxLevels = 17;

/// A block's key as an integer of 47 bits, for hash tables. kMaxVoxelsPerAxis allows 2^14 blocks
/// along an axis.
inline uint64_t block_id(BlockKey block) {
  return static_cast<uint64_t>(block.level) << 42 | static_cast<uint64_t>(block.index.z) << 28 |
         static_cast<uint64_t>(block.index.y) << 14 | static_cast<uint64_t>(block.index.x);
}

}  // namespace isosplat
