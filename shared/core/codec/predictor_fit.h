#pragma once

#include <cstdint>
#include <cstring>
#include <vector>

#include "shared/core/codec/lattice.h"

namespace isosplat {

/// Fits each class's weights to a chunk by ridge regression: least squares over a sample of its
/// points, with a penalty for the distance from the default weights. The arithmetic is that of IEEE
/// 754 in a fixed order, so every machine finds the same weights.
class PredictorFit {
 public:
  /// The weights of all classes, in the order of lattice.h.
  struct Weights {
    int32_t taps[kClasses][kTaps];
    uint32_t fitted = 0;  ///< bit c: class c has fitted weights, not the default ones
  };

  void clear() { samples_.clear(); }

  /// Adds a point. taps: its neighbours in other rows; row: its own row, from the point on.
  void add(uint32_t point_class, const TapPointers& taps, const int16_t* row) {
    Sample& sample = samples_.emplace_back();
    std::memcpy(sample.slot, taps.up, 8);
    std::memcpy(sample.slot + 4, taps.back, 8);
    std::memcpy(sample.slot + 8, taps.back_down, 8);
    std::memcpy(sample.slot + 12, taps.back_up, 8);
    sample.slot[3] = row[-1];
    sample.slot[7] = row[-2];
    sample.slot[kValueSlot] = row[0];
    sample.point_class = point_class;
  }

  /// stride: the chunk has about this many points for each point that was added.
  Weights solve(uint32_t stride);

 private:
  /// The layout of a sample, chosen so that four loads of four values fill it: taps 0–11 as in
  /// ClassWeights::rows, and in the gaps taps 12 and 13 and the value of the point. Slot 11 is not
  /// used.
  static constexpr int kSlots = 16;
  static constexpr int kValueSlot = 15;
  static constexpr int slot_of_tap(int tap) {
    return tap < 12 ? tap / 3 * 4 + tap % 3 : tap == 12 ? 3 : tap == 13 ? 7 : kValueSlot;
  }

  struct Sample {
    int16_t slot[kSlots];
    uint32_t point_class;
  };
  class Moments;

  static void differences(const int16_t* slots, float* to);
  void sort_by_class(size_t (&end)[kClasses]);
  Moments moments_of(size_t begin, size_t end) const;

  std::vector<Sample> samples_;
  std::vector<uint32_t> sorted_;  ///< indices of the samples, sorted by class
};

}  // namespace isosplat
