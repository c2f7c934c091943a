#pragma once

#include <wasm_simd128.h>

#include <cstdint>

/// 128-bit vectors (WebAssembly SIMD). simd_sse.h documents the functions.
namespace isosplat::simd {

using V = v128_t;
inline V load(const void* p) {
  return wasm_v128_load(p);
}
inline V load_two_halves(const void* low, const void* high) {
  return wasm_v128_load64_lane(high, wasm_v128_load64_zero(low), 1);
}
template <int kLane>
V load_lane16(V a, const int16_t* p) {
  return wasm_v128_load16_lane(p, a, kLane);
}
inline V set4(int32_t a, int32_t b, int32_t c, int32_t d) {
  return wasm_i32x4_make(a, b, c, d);
}
inline V splat16(uint32_t v) {
  return wasm_i16x8_splat(static_cast<int16_t>(v));
}
inline V splat32(uint32_t v) {
  return wasm_i32x4_splat(static_cast<int32_t>(v));
}
inline V multiply_add_pairs(V a, V b) {
  return wasm_i32x4_dot_i16x8(a, b);
}
inline V add32(V a, V b) {
  return wasm_i32x4_add(a, b);
}
inline V add16(V a, V b) {
  return wasm_i16x8_add(a, b);
}
inline V float_bits(V a, int n) {
  return wasm_u32x4_shr(wasm_f32x4_convert_i32x4(a), static_cast<uint32_t>(n));
}
inline V narrow32(V a, V b) {
  return wasm_i16x8_narrow_i32x4(a, b);
}
inline V narrow_u(V a, V b) {
  return wasm_u8x16_narrow_i16x8(a, b);
}
inline V sub32(V a, V b) {
  return wasm_i32x4_sub(a, b);
}
inline V shift_right_s32(V a, int n) {
  return wasm_i32x4_shr(a, static_cast<uint32_t>(n));
}
inline V sub16(V a, V b) {
  return wasm_i16x8_sub(a, b);
}
inline V xor_(V a, V b) {
  return wasm_v128_xor(a, b);
}
inline V and_(V a, V b) {
  return wasm_v128_and(a, b);
}
inline V or_(V a, V b) {
  return wasm_v128_or(a, b);
}
inline V min_u16(V a, V b) {
  return wasm_u16x8_min(a, b);
}
inline V max_u16(V a, V b) {
  return wasm_u16x8_max(a, b);
}
inline V greater_s16(V a, V b) {
  return wasm_i16x8_gt(a, b);
}
inline V greater_s32(V a, V b) {
  return wasm_i32x4_gt(a, b);
}
inline V shift_right_u16(V a, uint32_t n) {
  return wasm_u16x8_shr(a, n);
}
inline V shift_left_u16(V a, uint32_t n) {
  return wasm_i16x8_shl(a, n);
}
inline V shift_left_u32(V a, uint32_t n) {
  return wasm_i32x4_shl(a, n);
}
inline void store(void* p, V a) {
  wasm_v128_store(p, a);
}
inline V min_s16(V a, V b) {
  return wasm_i16x8_min(a, b);
}
inline V max_s16(V a, V b) {
  return wasm_i16x8_max(a, b);
}
inline V above_u16(V a, uint32_t limit) {
  return wasm_u16x8_gt(a, splat16(limit));
}
inline bool any_above_u16(V a, uint32_t limit) {
  return wasm_v128_any_true(above_u16(a, limit));
}
inline V low_halves16(V a, V b) {
  return wasm_i16x8_shuffle(a, b, 0, 8, 1, 9, 2, 10, 3, 11);
}
inline V high_halves16(V a, V b) {
  return wasm_i16x8_shuffle(a, b, 4, 12, 5, 13, 6, 14, 7, 15);
}
inline V low_halves32(V a, V b) {
  return wasm_i32x4_shuffle(a, b, 0, 4, 1, 5);
}
inline V high_halves32(V a, V b) {
  return wasm_i32x4_shuffle(a, b, 2, 6, 3, 7);
}
inline V low_halves64(V a, V b) {
  return wasm_i64x2_shuffle(a, b, 0, 2);
}
inline V high_halves64(V a, V b) {
  return wasm_i64x2_shuffle(a, b, 1, 3);
}
inline V high_halves(V a) {
  return wasm_u32x4_shr(a, 16);
}
inline V narrow_s(V a, V b) {
  return wasm_i8x16_narrow_i16x8(a, b);
}
inline uint32_t sign_bits8(V a) {
  return wasm_i8x16_bitmask(a);
}
inline uint32_t sign_bits32(V a) {
  return wasm_i32x4_bitmask(a);
}
inline V equal16(V a, V b) {
  return wasm_i16x8_eq(a, b);
}
inline V select(V a, V b, V set) {
  return wasm_v128_bitselect(b, a, set);
}
inline V sum_each(V a, V b, V c, V d) {
  const V ab =
      wasm_i32x4_add(wasm_i32x4_shuffle(a, b, 0, 4, 1, 5), wasm_i32x4_shuffle(a, b, 2, 6, 3, 7));
  const V cd =
      wasm_i32x4_add(wasm_i32x4_shuffle(c, d, 0, 4, 1, 5), wasm_i32x4_shuffle(c, d, 2, 6, 3, 7));
  return wasm_i32x4_add(wasm_i64x2_shuffle(ab, cd, 0, 2), wasm_i64x2_shuffle(ab, cd, 1, 3));
}
inline V load_half(const void* p) {
  return wasm_v128_load64_zero(p);
}
inline void store_half(void* p, V a) {
  wasm_v128_store64_lane(p, a, 0);
}
inline V splat8(uint32_t v) {
  return wasm_i8x16_splat(static_cast<int8_t>(v));
}
inline V add8(V a, V b) {
  return wasm_i8x16_add(a, b);
}
inline V equal8(V a, V b) {
  return wasm_i8x16_eq(a, b);
}
inline V shuffle8(V a, V at) {
  return wasm_i8x16_swizzle(a, at);
}

}  // namespace isosplat::simd
