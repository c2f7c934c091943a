#pragma once

#include <cstdint>
#include <vector>

#include "shared/core/preprocess/block_gather.h"

namespace isosplat {

/// How far the gradients of nearby cells agree, for each isovalue: near 1 on the boundary of an
/// object, near 0 in noise, whose gradients point anywhere. A sample of the pairs of cells that
/// have two cells' distance along an axis, and so no corner in common, is compared. Sums of
/// integers, one per quantized value at which pairs become active together, or cease to be.
struct GradientAgreement {
  std::vector<int64_t> cosines;  ///< kOne for parallel gradients
  std::vector<int64_t> pairs;

  static constexpr int64_t kOne = 256;

  explicit GradientAgreement(size_t quantized_values)
      : cosines(quantized_values), pairs(quantized_values) {}

  /// Compares cells of a block of level 0.
  void add(const GatheredBlock& block);
};

}  // namespace isosplat
