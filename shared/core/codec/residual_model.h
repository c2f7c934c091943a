#pragma once

#include <algorithm>
#include <cstdint>

#include "shared/core/codec/chunk_tables.h"
#include "shared/core/codec/ops.h"
#include "shared/core/sampling/cell.h"

namespace isosplat {

/// A residual r is coded as u = −2r (r ≤ 0) or 2r − 1 (r > 0), below 2^17.
inline uint32_t fold(int32_t residual) {
  // Arithmetic instead of a branch, because the sign is random.
  return static_cast<uint32_t>((2 * residual - 1) ^ (residual - 1) >> 31);
}
inline int32_t unfold(uint32_t folded) {
  const auto half = static_cast<int32_t>(folded >> 1), sign = -static_cast<int32_t>(folded & 1);
  return -(half ^ sign);
}

/// The low k bits of a folded residual u are stored raw. The rest, q = u >> k, is coded as a token
/// and raw bits: q ≤ 15 is its own token; token t ≥ 16 stands for [2^(t − 12), 2^(t − 11)), with t
/// − 12 raw bits.
struct Token {
  uint32_t token;
  uint32_t raw_bits;
};
inline Token token_of(uint32_t q) {
  // Conditional moves instead of a branch, because q < 16 is close to random.
  const auto bits = static_cast<uint32_t>(31 - __builtin_clz(q | 8));
  return {q < 16 ? q : bits + 12, q < 16 ? 0 : bits};
}

/// The smallest q of each token, and the number of raw bits that follow: base | bits << 24.
struct TokenInfo {
  uint32_t info[kTokens];

  constexpr TokenInfo() : info{} {
    for (uint32_t t = 0; t < kTokens; ++t) info[t] = t < 16 ? t : 1u << (t - 12) | (t - 12) << 24;
  }
};
inline constexpr TokenInfo kTokenInfo;

/// The model of a context: a token distribution of chunk_tables.h (its shape), and k (its shift).
/// There are two runs of 27 distributions. In each run, the first 23, from narrow to broad, are for
/// k = 0, and the last four for k ≥ 1.
inline constexpr uint32_t kPlainShapes = 23;
inline constexpr uint32_t kShiftedShapes = 4;
inline constexpr uint32_t kMaxShift = 13;
inline constexpr uint32_t kModelsPerRun = kPlainShapes + kShiftedShapes * kMaxShift;
inline constexpr uint32_t kModels = 2 * kModelsPerRun;
inline constexpr int kModelBits = 8;

struct Model {
  uint32_t shape;
  uint32_t shift;  ///< k
};
/// model < kModels
inline Model model_of(uint32_t model) {
  const uint32_t run = model / kModelsPerRun, i = model % kModelsPerRun;
  if (i < kPlainShapes) return {run * 27 + i, 0};
  return {run * 27 + kPlainShapes + (i - kPlainShapes) % kShiftedShapes,
          1 + (i - kPlainShapes) / kShiftedShapes};
}

/// The models of a run that have a given shift: [first, end), relative to the run.
struct ModelRange {
  uint32_t first, end;
};
inline ModelRange models_of_shift(uint32_t shift) {
  if (shift == 0) return {0, kPlainShapes};
  const uint32_t first = kPlainShapes + (shift - 1) * kShiftedShapes;
  return {first, first + kShiftedShapes};
}

/// A residual's context: its group and the level of its energy. Chunks of few cells merge levels.
inline constexpr int32_t kLevels = 12;
enum ContextGroup : int32_t {
  kEnclosed = 0,     ///< a lattice point whose neighbours at y − 1 and z − 1 are points
  kExposed = 1,      ///< another lattice point
  kIntervalMin = 2,  ///< how far a cell's interval begins below its least corner
  kIntervalMax = 3,  ///< how far it ends above its greatest corner
};
inline constexpr int32_t kGroups = 4;
inline constexpr int32_t kContexts = kGroups * kLevels;

/// A key combines octave and group of a residual; a chunk's LevelMap turns it into a context.
inline constexpr int32_t kKeys = kGroups * kOctaves;
inline int32_t residual_key(int32_t octave, int32_t group) {
  return octave + group * kOctaves;
}

/// A folded residual and the residual_key() of its context, in one number.
inline constexpr uint32_t kFoldedBits = 18;
inline constexpr uint32_t kFoldedMask = (1u << kFoldedBits) - 1;
inline uint32_t residual_entry(uint32_t folded, int32_t key) {
  return folded | static_cast<uint32_t>(key) << kFoldedBits;
}

/// Maps the octaves of energies to levels; each chunk has its own.
struct LevelMap {
  int32_t base = 0;   ///< 0 to 15: half octaves below count as level 0
  int32_t merge = 0;  ///< 0 to 4: 2^merge levels share one model

  int32_t level_of_octave(int32_t octave) const {
    return std::clamp(octave - base, 0, kLevels - 1) >> merge;
  }
  int32_t context_of_key(int32_t key) const {
    return key / kOctaves * kLevels + level_of_octave(key % kOctaves);
  }
  int32_t levels() const { return ((kLevels - 1) >> merge) + 1; }
};

/// The octave of both residuals of a cell's interval. `before` is interval_energy_of() the cell
/// coded before it, 0 for the first.
inline int32_t interval_octave(CellInterval corners, int32_t before) {
  return half_octave(static_cast<uint32_t>(2 * (corners.max - corners.min) + before));
}
inline int32_t interval_energy_of(int32_t below, int32_t beyond) {
  return std::min((below < 0 ? -below : below) + (beyond < 0 ? -beyond : beyond), 65535);
}

inline int32_t group_of_class(uint32_t point_class) {
  return (point_class & 6) == 6 ? kEnclosed : kExposed;
}

}  // namespace isosplat
