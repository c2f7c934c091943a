#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "shared/bands/band_planner.h"
#include "shared/grid/grid.h"
#include "shared/sampling/cell.h"

namespace isosplat {

/// Bins of equally many quantized values: bin i has the quantized values from first + i · width on.
struct QuantizedBins {
  uint32_t first = 0;
  uint32_t width = 1;
  uint32_t count = 1;

  /// The fewest quantized values per bin with which `most` bins cover the range: one per bin if
  /// they are few. Whole numbers, since bins of 19 and 20 quantized values in turn would show a
  /// comb that is not there.
  static QuantizedBins over(CellInterval range, uint32_t most) {
    const uint32_t quantized_values = range.max - range.min + 1u;
    const uint32_t width = (quantized_values + most - 1) / most;
    return {range.min, width, (quantized_values + width - 1) / width};
  }
};

/// What the build learns of a volume on its way: how often each quantized value occurs, and how
/// many cells of level 0 are active at each isovalue, and how steep they are. Sums of integers, so
/// that the result does not depend on who adds what.
class VolumeStatistics {
 public:
  VolumeStatistics();

  /// Counts quantized values (bytes where bits is 8). Missing voxels count only as missing.
  void add_values(const void* quantized_values, size_t count, uint8_t bits, bool has_missing);

  /// Adds a block of level 0, as the planner has counted it.
  void add_block(const BandPlanner& planner, std::span<const CellInterval> intervals);

  void add(const VolumeStatistics& other);

  uint64_t missing() const { return missing_; }

  /// Of all voxels with a value; {0, 0} where there is none.
  CellInterval range() const;

  /// Voxels in each bin.
  std::vector<uint64_t> histogram(const QuantizedBins& bins) const;

  /// Active cells of level 0 at the middle of each bin.
  std::vector<uint64_t> active_cells(const QuantizedBins& bins) const;

  /// Quantized isovalues, strongest first, at which the isosurface is steep for its size: peaks of
  /// the mean span of the active cells. At most `most`.
  std::vector<double> suggest(CellInterval range, size_t most) const;

 private:
  std::vector<uint64_t> voxels_, minima_, maxima_, spans_from_, spans_to_;  // per quantized value
  uint64_t missing_ = 0;
};

}  // namespace isosplat
