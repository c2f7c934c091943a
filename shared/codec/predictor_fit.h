#pragma once

#include <cstdint>
#include <cstring>
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

  /// A point: its class, its taps in other rows, and its own row from x on.
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

  /// stride: how many points there are for each one added.
  Weights solve(uint32_t stride);

 private:
  /// Taps 0–11 as in ClassWeights::rows, with the others and the value in the gaps: what four
  /// loads yield. Slot 11 means nothing.
  static constexpr int kSlots = 16;
  static constexpr int kValueSlot = 15;
  static constexpr int slot_of_tap(int tap) {
    return tap < 12 ? tap / 3 * 4 + tap % 3 : tap == 12 ? 3 : tap == 13 ? 7 : kValueSlot;
  }

  static void differences(const int16_t* slots, float* to);

  struct Sample {
    int16_t slot[kSlots];
    uint32_t point_class;
  };
  std::vector<Sample> samples_;
  std::vector<uint32_t> sorted_;  ///< the samples' places, class after class
};

}  // namespace isosplat
