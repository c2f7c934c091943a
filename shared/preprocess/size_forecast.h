#pragma once

#include <array>
#include <span>
#include <vector>

#include "shared/bands/band_planner.h"
#include "shared/preprocess/volume_sample.h"

namespace isosplat {

/// Weights of stored bytes, λ, for which sizes are forecast: from the least that a build may use to
/// one with which hardly any block is cut, at equal ratios.
inline constexpr size_t kCandidateWeights = 12;
inline constexpr double kMaxStorageWeight = 200;
using PerCandidate = std::array<double, kCandidateWeights>;

/// λ of each candidate, of which `least` is the first.
PerCandidate candidate_weights(double least);

/// Bytes per cell of blocks like a column, for each candidate.
struct ColumnForecast {
  PerCandidate finest;  ///< at level 0
  PerCandidate coarse;  ///< at level 1
};

/// Cuts a column of a sample as blocks will be. `options.storage_weight` is the least λ. `planner`:
/// reused.
ColumnForecast forecast_column(const SampleColumn& column, const BandOptions& options,
                               BandPlanner& planner);

/// How many bytes a store's blocks will take, as far as a sample of the volume tells: the sample's
/// columns are cut as blocks will be, for each candidate. What the codec makes of a volume is only
/// guessed at: SizeBudget compares with what was written.
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
  /// Bytes per cell of level `level` where a block of level 0 is.
  const PerCandidate& column(uint32_t level, Index3 block) const;

  Index3 voxels_;
  Index3 across_;
  int32_t stride_;
  PerCandidate storage_weights_;
  std::array<std::vector<PerCandidate>, 2> per_cell_;  ///< of each column: at level 0, at level 1
  std::array<PerCandidate, 2> all_;
};

}  // namespace isosplat
