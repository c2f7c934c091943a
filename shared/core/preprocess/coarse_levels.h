#pragma once

#include "shared/core/preprocess/block_gather.h"

namespace isosplat {

/// How the coarse levels of a store are built, where averages do not suffice: an implementation
/// knows what the voxels mean. Threads may call all functions at the same time, for different
/// blocks.
class CoarseLevels {
 public:
  virtual ~CoarseLevels() = default;

  /// Writes the coarse voxels that a block covers, as coarsen_block() does.
  virtual void coarsen_voxels(const Layer& layer, const GatheredBlock& block,
                              const CoarserLayer& coarser) const = 0;

  /// Sets the intervals of a gathered block of level 1 or above. They must contain those of the
  /// finer cells, which the block has, as far as these are active.
  virtual void set_intervals(const Layer& layer, GatheredBlock& block) const = 0;

  /// Whether the corners alone determine the surface in each cell (BlockVoxels::corners_suffice).
  virtual bool corners_suffice() const = 0;
};

}  // namespace isosplat
