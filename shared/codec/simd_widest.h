#pragma once

#include <cstdint>

#include "shared/codec/bit_positions.h"
#include "shared/codec/simd.h"

#if ISOSPLAT_CODEC_SIMD

/// For algorithms that are written once for vectors of any width: Widest is the widest there are,
/// a V or a pair of them, each half of which goes its own way.
namespace isosplat::simd {

template <class T>
T load_as(const void* p);
template <class T>
T splat16_as(uint32_t v);
template <class T>
T splat32_as(uint32_t v);

template <>
inline V load_as<V>(const void* p) {
  return load(p);
}
template <>
inline V splat16_as<V>(uint32_t v) {
  return splat16(v);
}
template <>
inline V splat32_as<V>(uint32_t v) {
  return splat32(v);
}

/// Of four lanes, the bytes of those whose bits are set, one after the other.
struct PresentBytes {
  alignas(16) uint8_t of[16][16];

  constexpr PresentBytes() : of{} {
    for (int bits = 0; bits < 16; ++bits) {
      for (int lane = 0, n = 0; lane < 4; ++lane) {
        if (!(bits >> lane & 1)) continue;
        for (int i = 0; i < 4; ++i) of[bits][n++] = static_cast<uint8_t>(4 * lane + i);
      }
    }
  }
};
inline constexpr PresentBytes kPresentBytes;

/// Stores those lanes whose bits are set, and returns where the next one goes; what lies there, as
/// far as it would go with all bits set, may be overwritten. low, high: as of low_halves16() and
/// high_halves16().
inline uint32_t* store_present(uint32_t* to, V low, V high, uint32_t present) {
  store(to, shuffle8(low, load(kPresentBytes.of[present & 15])));
  to += __builtin_popcount(present & 15);
  store(to, shuffle8(high, load(kPresentBytes.of[present >> 4])));
  return to + __builtin_popcount(present >> 4);
}

}  // namespace isosplat::simd

#if defined(__AVX2__)
#include "shared/codec/simd_avx2.h"
namespace isosplat::simd {
using Widest = W;
}
#else
namespace isosplat::simd {
using Widest = V;
}
#endif

#endif
