#pragma once

#include <array>
#include <span>
#include <vector>

#include "shared/core/bands/band_planner.h"
#include "shared/core/preprocess/volume_sample.h"

namespace isosplat {

/// Sizes are forecast for kCandidateWeights values of λ, in geometric progression from the least
/// that a build may use to kMaxStorageWeight, with which hardly any block is cut.
inline constexpr size_t kCandidateWeights = 12;
inline constexpr double kMaxStorageWeight = 200;
using PerCandidate = std::array<double, kCandidateWeights>;

/// λ of each candidate. least: of the first.
PerCandidate candidate_weights(double least);

/// Bytes per cell of blocks that resemble a column of the sample, for each candidate.
struct ColumnForecast {
  PerCandidate finest;  ///< at level 0
  PerCandidate coarse;  ///< at level 1
};

/// Cuts a column of a sample into bands like a block. options.storage_weight: the least λ. planner:
/// its memory is reused.
ColumnForecast forecast_column(const SampleColumn& column, const BandOptions& options,
                               BandPlanner& planner);

/// Forecasts the size of each block of a store from a sample of the volume, for each candidate λ:
/// the columns of the sample are cut into bands like blocks. The bytes per cell are a rough
/// estimate, which SizeBudget corrects by the sizes of the first blocks.
class SizeForecast {
 public:
  /// `columns`: forecast_column() of each column of the sample, with the same options.
  SizeForecast(const VolumeSample& sample, Index3 voxels, const BandOptions& options,
               std::span<const ColumnForecast> columns);

  double storage_weight(size_t candidate) const { return storage_weights_[candidate]; }

  /// Bytes of a block's chunks and of their directory.
  PerCandidate block(uint32_t level, Index3 index) const;

  /// Of all blocks of level 0, and of all coarser ones.
  const PerCandidate& all(bool coarse) const { return all_[coarse]; }

 private:
  /// Bytes per cell of a level at the position of a block of level 0.
  const PerCandidate& column(uint32_t level, Index3 block) const;

  Index3 voxels_;
  Index3 across_;
  int32_t stride_;
  PerCandidate storage_weights_;
  std::array<std::vector<PerCandidate>, 2> per_cell_;  ///< of each column: at level 0, at level 1
  std::array<PerCandidate, 2> all_;
};

}  // namespace isosplat
