#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "shared/core/sampling/cell.h"

namespace isosplat {

/// Options for cutting a block's value range into bands. A cell is stored in every band in which it
/// is active for some isovalue, and a query fetches the whole band that contains its isovalue. Few
/// bands make fetches large; many bands make the store large.
struct BandOptions {
  /// The weight of a stored byte, relative to a byte that a query for a random isovalue fetches.
  double storage_weight = 0.09;
  /// The fixed cost of a chunk, as a number of cells: directory record, chunk header, and the
  /// adaptation of the entropy coder.
  double overhead_cells = 300;
  /// The cumulative distribution of isovalues: for each quantized value, the probability that an
  /// isovalue is below it. 65537 entries from 0 to 1, borrowed. Empty: uniform.
  std::span<const double> isovalue_distribution;
  /// The approximate maximum number of positions that are considered for cuts.
  uint32_t max_candidates = 128;
};

/// Finds the cheapest cuts of a block's value range exactly, by dynamic programming. N: number of
/// cells; #(…): number of cells for which … holds. Between candidates tᵢ < tⱼ,
/// N − #(max ≤ tᵢ) − #(min ≥ tⱼ) cells are active somewhere in [tᵢ, tⱼ); both counts are look-ups.
/// With P from isovalue_distribution and λ = storage_weight, such a band costs
/// (P(tᵢ ≤ isovalue < tⱼ) + λ) · cells + λ · overhead_cells.
///
/// Keeps about 1 MB of scratch memory: one per thread.
class BandPlanner {
 public:
  BandPlanner();

  /// Counts the minima and maxima of a block's cells. Cells with min ≥ max are never active, and
  /// are left out.
  void count(std::span<const CellInterval> intervals);

  /// The union of the counted intervals; {0, 0} where there is none.
  CellInterval interval() const { return interval_; }

  /// Cells that are active for some isovalue.
  uint32_t cells() const { return cells_; }

  /// Cells whose minimum (maximum) is the quantized value `interval().min + i`, for i up to the
  /// interval's length inclusive.
  std::span<const uint32_t> minima() const;
  std::span<const uint32_t> maxima() const;

  /// The ends of the bands, ascending; the last is interval().max. Empty where cells() is 0.
  const std::vector<uint32_t>& plan(const BandOptions& options);

  /// The number of cells in each band of the last plan.
  const std::vector<uint32_t>& band_cells() const { return band_cells_; }

 private:
  void choose_candidates(uint32_t max_count);

  std::vector<uint32_t> minima_, maxima_;  // per quantized value
  CellInterval counted_;                   // the quantized values that may have a count
  CellInterval interval_;
  uint32_t cells_ = 0;
  struct Candidate {
    uint32_t quantized;
    uint32_t ended;      // cells with max ≤ quantized
    uint32_t not_begun;  // cells with min ≥ quantized
    double probability;  // that an isovalue is below `quantized`
  };
  std::vector<Candidate> candidates_;
  std::vector<double> cost_;
  std::vector<uint32_t> from_;
  std::vector<uint32_t> ends_, band_cells_;
};

}  // namespace isosplat
