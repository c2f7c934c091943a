#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "shared/core/bands/band_planner.h"
#include "shared/core/base/status.h"
#include "shared/core/grid/grid.h"
#include "shared/core/preprocess/block_gather.h"
#include "shared/core/preprocess/gradient_agreement.h"
#include "shared/core/sampling/cell.h"

namespace isosplat {

/// Bins of a histogram: bin i covers `width` quantized values from first + i · width on.
struct QuantizedBins {
  uint32_t first = 0;
  uint32_t width = 1;
  uint32_t count = 1;

  /// Bins of the smallest width with which at most `most` bins cover the range. All have the same
  /// width, because a mix of widths 19 and 20, say, would show peaks that the data do not have.
  static QuantizedBins over(CellInterval range, uint32_t most) {
    const uint32_t quantized_values = range.max - range.min + 1u;
    const uint32_t width = (quantized_values + most - 1) / most;
    return {range.min, width, (quantized_values + width - 1) / width};
  }
};

/// The surface at an isovalue.
struct SurfaceStatistics {
  double cells = 0;      ///< active cells of level 0
  double span = 0;       ///< mean of the cells' spans, in quantized values
  double agreement = 0;  ///< -1 to 1: see GradientAgreement; 0 if hardly any cells were compared
};

/// Statistics of a volume that the build collects: how often each quantized value occurs; number
/// and mean span of the cells of level 0 that are active at each isovalue, and how far their
/// gradients agree. Sums of integers, so that the result does not depend on the order of additions,
/// and so not on the number of threads.
class VolumeStatistics {
 public:
  VolumeStatistics();

  /// Counts quantized values of 8 or 16 bits. Missing voxels are counted as missing only.
  void add_values(const void* quantized_values, size_t count, uint8_t bits, bool has_missing);

  /// Adds a block of level 0, as the planner has counted it.
  void add_block(const BandPlanner& planner, const GatheredBlock& block);

  void add(const VolumeStatistics& other);

  /// Writes all statistics as a message, and adds the statistics of a message. Errors:
  /// invalid_argument (not such a message).
  std::vector<std::byte> bytes() const;
  Result<void> add(std::span<const std::byte> bytes);

  uint64_t missing() const { return missing_; }

  /// The range of all voxels that have a value; {0, 0} if there are none.
  CellInterval range() const;

  /// Voxels in each bin.
  std::vector<uint64_t> histogram(const QuantizedBins& bins) const;

  /// Active cells of level 0 at the middle of each bin.
  std::vector<uint64_t> active_cells(const QuantizedBins& bins) const;

  /// The surfaces at quantized isovalues, which ascend.
  std::vector<SurfaceStatistics> surfaces(std::span<const double> quantized_isovalues) const;

  /// Voxels with quantized values above `low` and up to `high`.
  double voxels_between(double low, double high) const;

 private:
  std::vector<uint64_t> voxels_, minima_, maxima_, spans_from_, spans_to_;  // per quantized value
  GradientAgreement agreement_;
  uint64_t missing_ = 0;
};

}  // namespace isosplat
