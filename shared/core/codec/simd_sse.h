#pragma once

#include <immintrin.h>

#include <cstdint>

/// 128-bit vectors (SSE4.1). simd_wasm.h defines the same functions for WebAssembly; simd.h
/// includes one of the two. Names end with the width of a lane in bits; `s` and `u` stand for
/// signed and unsigned lanes. Comparisons yield lanes of all ones or zero.
namespace isosplat::simd {

using V = __m128i;
inline V load(const void* p) {
  return _mm_loadu_si128(static_cast<const V*>(p));
}
/// Loads 8 bytes into the lower half, and 8 bytes into the upper half.
inline V load_two_halves(const void* low, const void* high) {
  const __m128 first = _mm_castsi128_ps(_mm_loadl_epi64(static_cast<const V*>(low)));
  return _mm_castps_si128(_mm_loadh_pi(first, static_cast<const __m64*>(high)));
}
/// Replaces one lane by a number in memory.
template <int kLane>
V load_lane16(V a, const int16_t* p) {
  return _mm_insert_epi16(a, *p, kLane);
}
inline V set4(int32_t a, int32_t b, int32_t c, int32_t d) {
  return _mm_setr_epi32(a, b, c, d);
}
inline V splat16(uint32_t v) {
  return _mm_set1_epi16(static_cast<int16_t>(v));
}
inline V splat32(uint32_t v) {
  return _mm_set1_epi32(static_cast<int32_t>(v));
}
/// Multiplies signed 16-bit lanes, and adds the products of each pair of neighbours: 32-bit lanes.
inline V multiply_add_pairs(V a, V b) {
  return _mm_madd_epi16(a, b);
}
inline V add32(V a, V b) {
  return _mm_add_epi32(a, b);
}
inline V add16(V a, V b) {
  return _mm_add_epi16(a, b);
}
/// Converts four 32-bit integers to floats, and shifts the bits of each float right by `n`.
inline V float_bits(V a, int n) {
  return _mm_srli_epi32(_mm_castps_si128(_mm_cvtepi32_ps(a)), n);
}
/// Converts the signed lanes of a, then of b, to lanes of half the width, saturating: 32 to signed
/// 16 bits, and 16 to unsigned 8 bits.
inline V narrow32(V a, V b) {
  return _mm_packs_epi32(a, b);
}
inline V narrow_u(V a, V b) {
  return _mm_packus_epi16(a, b);
}
inline V sub32(V a, V b) {
  return _mm_sub_epi32(a, b);
}
inline V shift_right_s32(V a, int n) {
  return _mm_srai_epi32(a, n);
}
inline V sub16(V a, V b) {
  return _mm_sub_epi16(a, b);
}
inline V xor_(V a, V b) {
  return _mm_xor_si128(a, b);
}
inline V and_(V a, V b) {
  return _mm_and_si128(a, b);
}
inline V or_(V a, V b) {
  return _mm_or_si128(a, b);
}
inline V min_u16(V a, V b) {
  return _mm_min_epu16(a, b);
}
inline V max_u16(V a, V b) {
  return _mm_max_epu16(a, b);
}
inline V greater_s16(V a, V b) {
  return _mm_cmpgt_epi16(a, b);
}
inline V greater_s32(V a, V b) {
  return _mm_cmpgt_epi32(a, b);
}
inline V shift_right_u16(V a, uint32_t n) {
  return _mm_srl_epi16(a, _mm_cvtsi32_si128(static_cast<int32_t>(n)));
}
inline V shift_left_u16(V a, uint32_t n) {
  return _mm_sll_epi16(a, _mm_cvtsi32_si128(static_cast<int32_t>(n)));
}
inline V shift_left_u32(V a, uint32_t n) {
  return _mm_sll_epi32(a, _mm_cvtsi32_si128(static_cast<int32_t>(n)));
}
inline void store(void* p, V a) {
  _mm_storeu_si128(static_cast<V*>(p), a);
}
inline V min_s16(V a, V b) {
  return _mm_min_epi16(a, b);
}
inline V max_s16(V a, V b) {
  return _mm_max_epi16(a, b);
}
inline V above_u16(V a, uint32_t limit) {
  return _mm_cmpeq_epi16(_mm_max_epu16(a, splat16(limit + 1)), a);
}
/// Whether any lane exceeds the limit.
inline bool any_above_u16(V a, uint32_t limit) {
  const V beyond = _mm_subs_epu16(a, splat16(limit));
  return !_mm_testz_si128(beyond, beyond);
}
/// Interleave the lanes of a and b: those of the lower halves, or those of the upper halves.
inline V low_halves16(V a, V b) {
  return _mm_unpacklo_epi16(a, b);
}
inline V high_halves16(V a, V b) {
  return _mm_unpackhi_epi16(a, b);
}
inline V low_halves32(V a, V b) {
  return _mm_unpacklo_epi32(a, b);
}
inline V high_halves32(V a, V b) {
  return _mm_unpackhi_epi32(a, b);
}
inline V low_halves64(V a, V b) {
  return _mm_unpacklo_epi64(a, b);
}
inline V high_halves64(V a, V b) {
  return _mm_unpackhi_epi64(a, b);
}
/// The upper 16 bits of each 32-bit lane.
inline V high_halves(V a) {
  return _mm_srli_epi32(a, 16);
}
/// Signed 16-bit to signed 8-bit lanes, saturating. Keeps the results of comparisons (0 and −1).
inline V narrow_s(V a, V b) {
  return _mm_packs_epi16(a, b);
}
/// The sign bits of all lanes as a number, lane 0 in bit 0.
inline uint32_t sign_bits8(V a) {
  return static_cast<uint32_t>(_mm_movemask_epi8(a));
}
inline uint32_t sign_bits32(V a) {
  return static_cast<uint32_t>(_mm_movemask_ps(_mm_castsi128_ps(a)));
}
inline V equal16(V a, V b) {
  return _mm_cmpeq_epi16(a, b);
}
/// The lanes of b where `set` is all ones, and those of a where `set` is zero.
inline V select(V a, V b, V set) {
  return _mm_blendv_epi8(a, b, set);
}
/// Lane i of the result is the sum of the four lanes of the i-th argument.
inline V sum_each(V a, V b, V c, V d) {
  const V ab = _mm_add_epi32(_mm_unpacklo_epi32(a, b), _mm_unpackhi_epi32(a, b));
  const V cd = _mm_add_epi32(_mm_unpacklo_epi32(c, d), _mm_unpackhi_epi32(c, d));
  return _mm_add_epi32(_mm_unpacklo_epi64(ab, cd), _mm_unpackhi_epi64(ab, cd));
}
/// Loads 8 bytes into the lower half; the upper half becomes zero.
inline V load_half(const void* p) {
  return _mm_loadl_epi64(static_cast<const V*>(p));
}
inline void store_half(void* p, V a) {
  _mm_storel_epi64(static_cast<V*>(p), a);
}
inline V splat8(uint32_t v) {
  return _mm_set1_epi8(static_cast<char>(v));
}
inline V add8(V a, V b) {
  return _mm_add_epi8(a, b);
}
inline V equal8(V a, V b) {
  return _mm_cmpeq_epi8(a, b);
}
/// Byte i of the result is byte at[i] of a. Requires at[i] < 16.
inline V shuffle8(V a, V at) {
  return _mm_shuffle_epi8(a, at);
}

}  // namespace isosplat::simd
