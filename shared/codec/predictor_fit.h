#pragma once

#include <cstdint>
#include <vector>

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

  void clear() { samples_.clear(); }

  /// A point: its class, its taps and its value.
  void add(uint32_t point_class, const int32_t* taps, int32_t value) {
    Sample sample;
    for (int i = 0; i < kTaps; ++i) {
      sample.difference[i] = static_cast<float>(taps[i] - taps[kImpliedTap]);
    }
    sample.difference[kTaps] = static_cast<float>(value - taps[kImpliedTap]);
    sample.difference[kTaps + 1] = 0;
    sample.point_class = point_class;
    samples_.push_back(sample);
  }

  /// stride: how many points there are for each one added.
  Weights solve(uint32_t stride);

 private:
  /// The taps and then the value, all less the implied tap; a zero fills up the vector.
  struct Sample {
    float difference[16];
    uint32_t point_class;
  };
  std::vector<Sample> samples_;
  std::vector<const float*> by_class_;  ///< the samples' differences, class after class
};

}  // namespace isosplat
