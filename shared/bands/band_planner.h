#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "shared/sampling/cell.h"

namespace isosplat {

/// How a block's value range is cut into bands. A cell is stored in every band in which it is
/// active for some isovalue, and a query fetches the whole band that its isovalue lies in: few cuts
/// make fetches large, many make the store large.
struct BandOptions {
  /// The one dial: how much a byte stored weighs against a byte fetched by a random isovalue.
  double storage_weight = 0.09;
  /// What a chunk costs beside its cells, as a number of cells: directory record, framing, and the
  /// statistics that its entropy coder has yet to learn.
  double overhead_cells = 300;
  /// How likely an isovalue is below each quantized value, ascending from 0 to 1: 65537 entries,
  /// borrowed. Empty: isovalues are spread evenly over all codes.
  std::span<const double> isovalue_distribution;
  /// At most about this many places are considered for a cut; all, where there are no more.
  uint32_t max_candidates = 128;
};

/// Cuts the value range of a block where it is cheapest, by a dynamic programme with an exact
/// answer. Between candidates t₀ < t₁ < …, N − #(max ≤ tᵢ) − #(min ≥ tⱼ) cells are active somewhere
/// in [tᵢ, tⱼ): two look-ups in cumulative counts. Such a band costs
/// (P(tᵢ ≤ isovalue < tⱼ) + λ) · cells + λ · overhead.
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

  /// Cells in each band of the plan made last.
  const std::vector<uint32_t>& band_cells() const { return band_cells_; }

 private:
  void choose_candidates(uint32_t most);

  std::vector<uint32_t> minima_, maxima_;  // per quantized value
  CellInterval counted_;                   // the quantized values that may have a count
  CellInterval interval_;
  uint32_t cells_ = 0;
  struct Candidate {
    uint32_t quantized;
    uint32_t ended;      // cells with max ≤ quantized value
    uint32_t not_begun;  // cells with min ≥ quantized value
    double likely;       // that an isovalue is below quantized value
  };
  std::vector<Candidate> candidates_;
  std::vector<double> cost_;
  std::vector<uint32_t> from_;
  std::vector<uint32_t> ends_, band_cells_;
};

}  // namespace isosplat
