#pragma once

#include "shared/core/preprocess/coarse_levels.h"

namespace isosplat {

/// The coarse levels of categories, such as labels, which have no averages: a coarse voxel has the
/// value of the finer voxel at its position.
class PickedLevels : public CoarseLevels {
 public:
  void coarsen_voxels(const Layer& layer, const GatheredBlock& block,
                      const CoarserLayer& coarser) const override;
  /// Leaves the intervals as they are: they contain those of the finer cells.
  void set_intervals(const Layer&, GatheredBlock&) const override {}
  bool corners_suffice() const override { return false; }
};

}  // namespace isosplat
