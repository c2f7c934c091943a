#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "shared/core/grid/grid.h"

namespace isosplat {

/// The coarse voxels that a block writes along one axis: [begin, end). The last block also writes
/// the last voxel of the level.
struct CoarseVoxels {
  int32_t begin, end;
};

inline CoarseVoxels coarse_voxels(int32_t block, int32_t block_cells, int32_t cells,
                                  int32_t coarse_cells) {
  const int32_t begin = block * (kBlockCells / 2);
  const bool is_last = block * kBlockCells + block_cells == cells;
  return {begin, is_last ? coarse_cells + 1 : begin + kBlockCells / 2};
}

/// The positions 2c − kReach to 2c + kReach of the finer level for coarse voxel c, clamped to
/// 0 … last.
template <int32_t kReach>
std::array<int32_t, 2 * kReach + 1> finer_voxels(int32_t coarse, int32_t last) {
  const int32_t centre = std::min(2 * coarse, last);
  std::array<int32_t, 2 * kReach + 1> at;
  for (int32_t i = -kReach; i <= kReach; ++i) {
    at[static_cast<size_t>(i + kReach)] = std::clamp(centre + i, 0, last);
  }
  return at;
}

}  // namespace isosplat
