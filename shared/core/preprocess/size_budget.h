#pragma once

#include <array>
#include <cstdint>

#include "shared/core/preprocess/size_forecast.h"

namespace isosplat {

/// Chooses λ, the weight of a stored byte, so that a store does not exceed a number of bytes: the
/// least λ for which the bytes written so far plus the forecast of the rest stay below. Forecasts
/// are corrected by the ratio of actual to forecast sizes of the blocks so far. The results depend
/// only on the finished blocks and their order.
class SizeBudget {
 public:
  /// max_bytes: of the whole file; fixed_bytes: the part of them that is neither chunks nor
  /// directory pages.
  SizeBudget(const SizeForecast& forecast, double max_bytes, double fixed_bytes);

  /// The λ for the next blocks, and their limits.
  struct Grant {
    double storage_weight = 0;
    /// Bytes that remain if every further block takes its minimum. Blocks that are built at the
    /// same time share them.
    double slack = 0;
    std::array<double, 2> correction{1, 1};  ///< factors for forecasts: level 0, coarser levels
  };
  Grant grant() const;

  /// Whether the rest would fit with the least λ even if it were several times as large as
  /// forecast, so that sizes need not be watched block by block.
  bool is_ample() const;

  /// The least bytes that a block is expected to take.
  double min_bytes(const Grant& grant, uint32_t level, Index3 block) const;

  /// Reports that the next block in the store's order was built with storage_weight, and its size.
  void add(uint32_t level, Index3 block, double storage_weight, double bytes);

 private:
  /// Forecast and actual sizes of level 0, or of all coarser levels.
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
