#pragma once

#include <array>
#include <vector>

#include "native/builder/volume_sample.h"
#include "shared/slabs/slab_planner.h"

namespace isosplat {

/// Weights of stored bytes, λ, for which sizes are forecast: from the least that a build may use to
/// one with which hardly any block is cut, at equal ratios.
inline constexpr size_t kDials = 12;
inline constexpr double kMostLambda = 200;
using PerDial = std::array<double, kDials>;

/// How many bytes a store's blocks will take, as far as a sample of the volume tells: the sample's
/// columns are cut as blocks will be, for each dial. What the codec makes of a volume is only
/// guessed at: SizeBudget compares with what was written.
class SizeForecast {
 public:
  /// `options.lambda` is the least λ. Columns are planned on up to `threads` threads.
  SizeForecast(const VolumeSample& sample, Index3 voxels, const SlabOptions& options,
               unsigned threads);

  double lambda(size_t dial) const { return lambdas_[dial]; }

  /// Bytes of a block's chunks and of their directory.
  PerDial block(uint32_t level, Index3 index) const;

  /// Of all blocks of level 0, and of all coarser ones.
  const PerDial& all(bool coarse) const { return all_[coarse]; }

 private:
  /// Bytes per cell of level `level` where a block of level 0 is.
  const PerDial& column(uint32_t level, Index3 block) const;

  Index3 voxels_;
  Index3 across_;
  int32_t stride_;
  PerDial lambdas_;
  std::array<std::vector<PerDial>, 2> per_cell_;  ///< of each column: at level 0, at level 1
  std::array<PerDial, 2> all_;
};

}  // namespace isosplat
