#include "shared/core/bands/band_planner.h"

#include <algorithm>

namespace isosplat {

BandPlanner::BandPlanner() : minima_(65536), maxima_(65536) {}

void BandPlanner::count(std::span<const CellInterval> intervals) {
  // Only the range of the last block has counts that are not 0.
  std::fill(minima_.begin() + counted_.min, minima_.begin() + counted_.max + 1, 0);
  std::fill(maxima_.begin() + counted_.min, maxima_.begin() + counted_.max + 1, 0);
  QuantizedValue low = 65535, high = 0;
  // As an array of quantized values, so that the compiler vectorises the loop.
  static_assert(sizeof(CellInterval) == 2 * sizeof(QuantizedValue));
  const auto* const quantized_values = reinterpret_cast<const QuantizedValue*>(intervals.data());
  for (size_t i = 0; i < 2 * intervals.size(); ++i) {
    low = std::min(low, quantized_values[i]);
    high = std::max(high, quantized_values[i]);
  }
  counted_ = intervals.empty() ? CellInterval{} : CellInterval{low, high};
  for (const CellInterval interval : intervals) {
    // A branch would be hard to predict, so this is arithmetic.
    const uint32_t active = interval.min < interval.max;
    minima_[interval.min] += active;
    maxima_[interval.max] += active;
  }
  cells_ = 0;
  interval_ = {};
  for (uint32_t quantized = counted_.min; quantized <= counted_.max; ++quantized) {
    if (cells_ == 0) interval_.min = static_cast<QuantizedValue>(quantized);
    if (maxima_[quantized] > 0) interval_.max = static_cast<QuantizedValue>(quantized);
    cells_ += minima_[quantized];
  }
  if (cells_ == 0) interval_ = {};
}

std::span<const uint32_t> BandPlanner::minima() const {
  return std::span(minima_).subspan(interval_.min, interval_.max - interval_.min + 1u);
}

std::span<const uint32_t> BandPlanner::maxima() const {
  return std::span(maxima_).subspan(interval_.min, interval_.max - interval_.min + 1u);
}

void BandPlanner::choose_candidates(uint32_t max_count) {
  const uint32_t low = interval_.min, high = interval_.max;
  // A third of the candidates are evenly spaced. The others divide the beginnings and ends of the
  // intervals into equal numbers, because moving a cut changes the cells of the bands only where an
  // interval begins or ends.
  const bool take_all = high - low < max_count;
  const uint32_t step = std::max(1u, (high - low) / std::max(1u, max_count / 3));
  const uint32_t quantum = std::max(1u, 2 * cells_ / std::max(1u, max_count - max_count / 3));
  candidates_.clear();
  uint32_t ended = 0, begun = 0, since = 0;
  for (uint32_t quantized = low; quantized <= high; ++quantized) {
    // A cell of [min, max) is active below `quantized` iff min < quantized, and from `quantized` on
    // iff max > quantized.
    ended += maxima_[quantized];
    since += maxima_[quantized] + minima_[quantized];
    if (quantized == low || quantized == high || take_all || since >= quantum ||
        (quantized - low) % step == 0) {
      candidates_.push_back({quantized, ended, cells_ - begun, 0});
      since = 0;
    }
    begun += minima_[quantized];
  }
}

const std::vector<uint32_t>& BandPlanner::plan(const BandOptions& options) {
  ends_.clear();
  band_cells_.clear();
  if (cells_ == 0) return ends_;
  choose_candidates(options.max_candidates);
  const size_t n = candidates_.size();
  cost_.assign(n, 0);
  from_.assign(n, 0);
  for (Candidate& candidate : candidates_) {
    candidate.probability = options.isovalue_distribution.empty()
                                ? candidate.quantized / 65536.0
                                : options.isovalue_distribution[candidate.quantized];
  }
  const double fixed = options.storage_weight * options.overhead_cells;
  for (size_t j = 1; j < n; ++j) {
    const Candidate end = candidates_[j];
    const double remaining = static_cast<double>(cells_ - end.not_begun);
    double best = 0;
    uint32_t best_from = 0;
    for (size_t i = 0; i < j; ++i) {
      const double cells = remaining - static_cast<double>(candidates_[i].ended);
      const double share = end.probability - candidates_[i].probability;
      const double cost =
          cost_[i] + (share + options.storage_weight) * cells + (cells > 0 ? fixed : 0);
      if (i == 0 || cost < best) {
        best = cost;
        best_from = static_cast<uint32_t>(i);
      }
    }
    cost_[j] = best;
    from_[j] = best_from;
  }
  for (auto j = static_cast<uint32_t>(n - 1); j > 0; j = from_[j]) {
    ends_.push_back(candidates_[j].quantized);
    band_cells_.push_back(cells_ - candidates_[j].not_begun - candidates_[from_[j]].ended);
  }
  std::reverse(ends_.begin(), ends_.end());
  std::reverse(band_cells_.begin(), band_cells_.end());
  return ends_;
}

}  // namespace isosplat
