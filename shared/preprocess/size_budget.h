#pragma once

#include <array>
#include <cstdint>

#include "shared/preprocess/size_forecast.h"

namespace isosplat {

/// Chooses λ, the weight of a stored byte, so that a store stays within a number of bytes: the
/// least λ with which what is written and what is forecast for the rest stay below. Forecasts are
/// corrected by how blocks so far compare with theirs. What it says depends on the blocks finished
/// and their order, on nothing else.
class SizeBudget {
 public:
  /// `max_bytes`: of the whole file, of which `fixed_bytes` are taken by the head.
  SizeBudget(const SizeForecast& forecast, double max_bytes, double fixed_bytes);

  /// What a block is to be built with.
  struct Grant {
    double storage_weight = 0;
    /// Bytes that are left when every block to come takes as few as it can: those that are built at
    /// a time share them.
    double slack = 0;
    std::array<double, 2> correction{1, 1};  ///< of forecasts: level 0, coarser levels
  };
  Grant grant() const;

  /// Whether the rest would fit with the least λ even if it were several times as large as
  /// forecast, so that sizes need not be watched block by block.
  bool is_ample() const;

  /// What a block takes at least, as far as is known at a grant.
  double min_bytes(const Grant& grant, uint32_t level, Index3 block) const;

  /// The next block, in the store's order, was built with `storage_weight` and took so many bytes.
  void add(uint32_t level, Index3 block, double storage_weight, double bytes);

 private:
  /// Forecast and actual sizes of one level or of several.
  struct Part {
    PerCandidate remaining{};  ///< forecast of blocks to come
    double forecast = 0;       ///< of the blocks so far
    double actual = 0;
    double correction() const { return actual / forecast; }
  };
  double at(const PerCandidate& bytes, double storage_weight) const;
  double total(size_t candidate, const std::array<double, 2>& correction) const;

  const SizeForecast& forecast_;
  double max_, spent_;
  std::array<Part, 2> parts_;
};

}  // namespace isosplat
