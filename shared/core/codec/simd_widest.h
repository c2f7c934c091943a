#pragma once

#include <cstdint>

#include "shared/core/codec/bit_positions.h"
#include "shared/core/codec/simd.h"

#if ISOSPLAT_CODEC_SIMD

/// Lets an algorithm be written once for vectors of any width. Widest is the widest vector type of
/// the target: W (256 bits, AVX2) or V (128 bits).
namespace isosplat::simd {

/// load(), splat16() and splat32() for the vector type T.
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

/// For each 4-bit mask, the argument of shuffle8() that compacts a vector: it moves the 32-bit
/// lanes in the mask to the front, in their order.
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

/// Stores the 32-bit lanes whose bits in `present` are set, without gaps, and returns the end of
/// the stored lanes. Always writes memory for all lanes, so the space after the end may be
/// overwritten. low, high: the results of low_halves16() and high_halves16() with the same
/// arguments; bit i stands for lane i of these arguments.
inline uint32_t* store_present(uint32_t* to, V low, V high, uint32_t present) {
  store(to, shuffle8(low, load(kPresentBytes.of[present & 15])));
  to += __builtin_popcount(present & 15);
  store(to, shuffle8(high, load(kPresentBytes.of[present >> 4])));
  return to + __builtin_popcount(present >> 4);
}

}  // namespace isosplat::simd

#if defined(__AVX2__)
#include "shared/core/codec/simd_avx2.h"
namespace isosplat::simd {
using Widest = W;
}
#else
namespace isosplat::simd {
using Widest = V;
}
#endif

#endif
