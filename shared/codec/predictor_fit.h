#pragma once

#include <cstdint>

#include "shared/codec/lattice.h"

namespace isosplat {

/// Fits each class's weights to a chunk: least squares over a sample of its points, drawn towards
/// the default weights where there is little evidence. Plain IEEE arithmetic in a fixed order, so
/// that every machine finds the same weights.
class PredictorFit {
 public:
  /// Weights, in the order of lattice.h, and which classes do not use the default ones.
  struct Weights {
    int32_t taps[kClasses][kTaps];
    uint32_t fitted = 0;  ///< bit per class
  };

  void clear();

  /// A point: its class, its taps and its value.
  void add(uint32_t point_class, const int32_t* taps, int32_t value);

  /// stride: how many points there are for each one added.
  Weights solve(uint32_t stride) const;

 private:
  static constexpr int kUnknowns = kTaps - 1;

  /// Sums of products of the taps and the value, all less the implied tap.
  struct Moments {
    uint32_t count;
    float product[kUnknowns][16];
  };
  Moments moments_[kClasses];
};

}  // namespace isosplat
