#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "shared/core/preprocess/layer.h"

namespace isosplat {

/// The coarse cells that cover a block.
inline LevelBox coarse_cells_of(const LevelGrid& grid, Index3 block) {
  const Index3 cells = block_cells(grid, block);
  constexpr int32_t kHalf = kBlockCells / 2;
  return {{block.x * kHalf, block.y * kHalf, block.z * kHalf},
          {(cells.x + 1) / 2, (cells.y + 1) / 2, (cells.z + 1) / 2}};
}

/// The coarse voxels that a block writes: the last one of an axis also writes the level's last
/// voxel.
inline LevelBox coarse_voxels_of(const LevelGrid& grid, Index3 block) {
  LevelBox box = coarse_cells_of(grid, block);
  box.size.x += block.x + 1 == grid.blocks.x;
  box.size.y += block.y + 1 == grid.blocks.y;
  box.size.z += block.z + 1 == grid.blocks.z;
  return box;
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
