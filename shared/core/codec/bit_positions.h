#pragma once

#include <cstdint>

namespace isosplat {

/// The positions of the set bits of each byte, ascending.
struct BitPositions {
  uint8_t of[256][8];

  constexpr BitPositions() : of{} {
    for (int byte = 0; byte < 256; ++byte) {
      for (int bit = 0, n = 0; bit < 8; ++bit) {
        if (byte >> bit & 1) of[byte][n++] = static_cast<uint8_t>(bit);
      }
    }
  }
};
inline constexpr BitPositions kBitPositions;

}  // namespace isosplat
