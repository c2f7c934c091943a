#pragma once

#include <cstddef>
#include <cstdint>

namespace isosplat {

/// Reads the frequencies of a distribution, which is written with one letter for each symbol.
/// Letter number c (A = 0, … Z = 25, a = 26, …) stands for the frequency ⌊2^(c/4)⌋. The difference
/// from the total is added to the most frequent symbol, or to the first of several equally frequent
/// ones.
inline constexpr uint32_t kQuadTotal = 4096;
inline constexpr uint32_t kTokenTotal = 2048;
inline void read_distribution(const char* letters, size_t symbols, uint32_t total,
                              uint16_t* frequencies) {
  static constexpr uint32_t kQuarters[4] = {65536, 77935, 92681, 110217};  // 2^(16 + i/4)
  uint32_t rest = total;
  size_t most_frequent = 0;
  for (size_t i = 0; i < symbols; ++i) {
    const auto code =
        static_cast<uint32_t>(letters[i] <= 'Z' ? letters[i] - 'A' : letters[i] - 'a' + 26);
    frequencies[i] = static_cast<uint16_t>(kQuarters[code & 3] << (code >> 2) >> 16);
    rest -= frequencies[i];
    if (frequencies[i] > frequencies[most_frequent]) most_frequent = i;
  }
  frequencies[most_frequent] = static_cast<uint16_t>(frequencies[most_frequent] + rest);
}

/// Distributions of the sixteen values of a quad by its context (cell_mask.h); total 4096.
extern const char kQuadTable[256][17];

/// Distributions of the 29 tokens of a residual (residual_model.h); total 2048.
inline constexpr int kTokens = 29;
inline constexpr int kShapes = 54;
extern const char kTokenTable[kShapes][kTokens + 1];

/// Weights, in 1/128, of a corner's predictor by its class; their order is that of lattice.h.
inline constexpr int kTaps = 14;
inline constexpr int kClasses = 16;
extern const int16_t kDefaultWeights[kClasses][kTaps];

}  // namespace isosplat
