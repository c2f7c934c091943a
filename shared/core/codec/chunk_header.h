#pragma once

#include <algorithm>
#include <cstdint>

#include "shared/core/codec/bit_stream.h"
#include "shared/core/codec/lattice.h"
#include "shared/core/codec/predictor_fit.h"
#include "shared/core/codec/residual_model.h"

namespace isosplat {

inline constexpr int32_t kMaxIntervalShift = 7;

/// The header of a chunk (layout: CHUNK.md).
struct ChunkHeader {
  bool wide = false;           ///< quantized values may exceed 255
  int32_t interval_shift = 0;  ///< 0 to kMaxIntervalShift: in all intervals, this many low bits
                               ///< are zero in min and one in max, and are not stored
  LevelMap levels;
  uint32_t fitted = 0;  ///< bit c: class c has fitted weights, not the default ones
  int32_t taps[kClasses][kTaps];
  uint8_t model[kContexts] = {};  ///< kNoModel if the context is not used

  CellInterval shifted(CellInterval interval) const {
    return {static_cast<QuantizedValue>(interval.min >> interval_shift),
            static_cast<QuantizedValue>(interval.max >> interval_shift)};
  }
};

inline constexpr int kHeaderVersion = 0;
inline constexpr int kHeaderVersionBits = 2;
inline constexpr uint8_t kNoModel = 255;

/// A weight is stored as its difference from the default one, folded, in Rice code: the upper part
/// in unary (fewer than kMaxUnary ones, then a zero), then the lower bits. If the upper part is too
/// large for that: kMaxUnary ones, then the whole number in kPlainWeightBits.
inline constexpr uint32_t kMaxUnary = 12;
inline constexpr int kPlainWeightBits = 13;

inline void write_header(const ChunkHeader& header, bool has_intervals, BitWriter& bits) {
  bits.put(kHeaderVersion, kHeaderVersionBits);
  bits.put(header.wide, 1);
  if (has_intervals) bits.put(static_cast<uint32_t>(header.interval_shift), 3);
  bits.put(static_cast<uint32_t>(header.levels.base), 4);
  bits.put(static_cast<uint32_t>(header.levels.merge), 3);
  for (int group = 0; group < (has_intervals ? kGroups : 2); ++group) {
    for (int level = 0; level < header.levels.levels(); ++level) {
      const uint8_t model = header.model[group * kLevels + level];
      bits.put(model != kNoModel, 1);
      if (model != kNoModel) bits.put(model, kModelBits);
    }
  }
  bits.put(header.fitted != 0, 1);
  if (!header.fitted) return;
  bits.put(header.fitted, kClasses);

  const auto for_each_difference = [&](auto f) {
    for (int c = 0; c < kClasses; ++c) {
      if (!(header.fitted >> c & 1)) continue;
      for (int i = 0; i < kTaps; ++i) {
        if (i != kImpliedTap) f(fold(header.taps[c][i] - kDefaultWeights[c][i]));
      }
    }
  };
  uint32_t best = 0, best_cost = ~0u;
  for (uint32_t low = 0; low < 8; ++low) {
    uint32_t cost = 0;
    for_each_difference([&](uint32_t u) {
      cost += (u >> low) < kMaxUnary ? (u >> low) + 1 + low : kMaxUnary + kPlainWeightBits;
    });
    if (cost < best_cost) best_cost = cost, best = low;
  }
  bits.put(best, 3);
  for_each_difference([&](uint32_t u) {
    const uint32_t high = u >> best;
    if (high < kMaxUnary) {
      bits.put((1u << high) - 1, high + 1);
      bits.put(u & ((1u << best) - 1), best);
    } else {
      bits.put((1u << kMaxUnary) - 1, kMaxUnary);
      bits.put(u, kPlainWeightBits);
    }
  });
}

/// Returns false if the header is malformed: a value is outside its limits, or the version is
/// unknown. Reads at most 1,300 bytes.
inline bool read_header(BitReader& bits, bool has_intervals, ChunkHeader& header) {
  if (bits.get(kHeaderVersionBits) != kHeaderVersion) return false;
  header.wide = bits.get(1) != 0;
  header.interval_shift = has_intervals ? static_cast<int32_t>(bits.get(3)) : 0;
  header.levels.base = static_cast<int32_t>(bits.get(4));
  header.levels.merge = static_cast<int32_t>(bits.get(3));
  if (header.levels.merge > 4) return false;
  std::fill_n(header.model, kContexts, kNoModel);
  for (int group = 0; group < (has_intervals ? kGroups : 2); ++group) {
    for (int level = 0; level < header.levels.levels(); ++level) {
      if (!bits.get(1)) continue;
      const uint32_t model = bits.get(kModelBits);
      if (model >= kModels) return false;
      header.model[group * kLevels + level] = static_cast<uint8_t>(model);
    }
  }
  for (int c = 0; c < kClasses; ++c) {
    for (int i = 0; i < kTaps; ++i) header.taps[c][i] = kDefaultWeights[c][i];
  }
  header.fitted = 0;
  if (!bits.get(1)) return true;
  header.fitted = bits.get(kClasses);
  if (!header.fitted) return false;
  const uint32_t low = bits.get(3);
  for (int c = 0; c < kClasses; ++c) {
    if (!(header.fitted >> c & 1)) continue;
    int32_t rest = 1 << kWeightBits;
    for (int i = 0; i < kTaps; ++i) {
      if (i == kImpliedTap) continue;
      uint32_t high = 0;
      while (high < kMaxUnary && bits.get(1)) ++high;
      const uint32_t u =
          high < kMaxUnary ? high << low | bits.get(low) : bits.get(kPlainWeightBits);
      const int32_t weight = kDefaultWeights[c][i] + unfold(u);
      if (std::abs(weight) > kMaxWeight) return false;
      header.taps[c][i] = weight;
      rest -= weight;
    }
    header.taps[c][kImpliedTap] = rest;
  }
  return true;
}

}  // namespace isosplat
