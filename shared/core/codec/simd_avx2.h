#pragma once

#include <immintrin.h>

#include <cstdint>

#include "shared/core/codec/bit_positions.h"

/// 256-bit vectors (AVX2). A function that has the name of a function of simd_sse.h does the same
/// with each 128-bit half; the halves do not mix.
namespace isosplat::simd {

using W = __m256i;
template <>
inline W load_as<W>(const void* p) {
  return _mm256_loadu_si256(static_cast<const W*>(p));
}
template <>
inline W splat16_as<W>(uint32_t v) {
  return _mm256_set1_epi16(static_cast<int16_t>(v));
}
template <>
inline W splat32_as<W>(uint32_t v) {
  return _mm256_set1_epi32(static_cast<int32_t>(v));
}
inline void store(void* p, W a) {
  _mm256_storeu_si256(static_cast<W*>(p), a);
}
inline W multiply_add_pairs(W a, W b) {
  return _mm256_madd_epi16(a, b);
}
inline W add32(W a, W b) {
  return _mm256_add_epi32(a, b);
}
inline W sub32(W a, W b) {
  return _mm256_sub_epi32(a, b);
}
inline W add16(W a, W b) {
  return _mm256_add_epi16(a, b);
}
inline W sub16(W a, W b) {
  return _mm256_sub_epi16(a, b);
}
inline W and_(W a, W b) {
  return _mm256_and_si256(a, b);
}
inline W or_(W a, W b) {
  return _mm256_or_si256(a, b);
}
inline W xor_(W a, W b) {
  return _mm256_xor_si256(a, b);
}
inline W min_s16(W a, W b) {
  return _mm256_min_epi16(a, b);
}
inline W max_s16(W a, W b) {
  return _mm256_max_epi16(a, b);
}
inline W greater_s16(W a, W b) {
  return _mm256_cmpgt_epi16(a, b);
}
inline uint32_t sign_bits8(W a) {
  return static_cast<uint32_t>(_mm256_movemask_epi8(a));
}
inline W equal16(W a, W b) {
  return _mm256_cmpeq_epi16(a, b);
}
inline W select(W a, W b, W set) {
  return _mm256_blendv_epi8(a, b, set);
}
inline W shift_left_u16(W a, uint32_t n) {
  return _mm256_slli_epi16(a, static_cast<int>(n));
}
inline W shift_right_s32(W a, int n) {
  return _mm256_srai_epi32(a, n);
}
inline W low_halves16(W a, W b) {
  return _mm256_unpacklo_epi16(a, b);
}
inline W high_halves16(W a, W b) {
  return _mm256_unpackhi_epi16(a, b);
}
inline W narrow32(W a, W b) {
  return _mm256_packs_epi32(a, b);
}
inline W float_bits(W a, int n) {
  return _mm256_srli_epi32(_mm256_castps_si256(_mm256_cvtepi32_ps(a)), n);
}
/// narrow_u() of the lower and the upper half.
inline V narrow_u_halves(W a) {
  return narrow_u(_mm256_castsi256_si128(a), _mm256_extracti128_si256(a, 1));
}
inline uint32_t* store_present(uint32_t* to, W low, W high, uint32_t present) {
  const auto eight = [&](W lanes, uint32_t bits) {
    const W from = _mm256_cvtepu8_epi32(load_half(kBitPositions.of[bits]));
    store(to, _mm256_permutevar8x32_epi32(lanes, from));
    to += __builtin_popcount(bits);
  };
  eight(_mm256_permute2x128_si256(low, high, 0x20), present & 255);
  eight(_mm256_permute2x128_si256(low, high, 0x31), present >> 8);
  return to;
}

}  // namespace isosplat::simd
