#include "shared/import/voxels/stored_voxels.h"

#include <bit>
#include <cstdint>
#include <cstring>
#include <vector>

namespace isosplat::import {
namespace {

uint16_t swapped(uint16_t value) {
  return __builtin_bswap16(value);
}
uint32_t swapped(uint32_t value) {
  return __builtin_bswap32(value);
}
uint64_t swapped(uint64_t value) {
  return __builtin_bswap64(value);
}

template <class Word>
void swap_each(std::span<std::byte> bytes) {
  for (size_t i = 0; i + sizeof(Word) <= bytes.size(); i += sizeof(Word)) {
    Word word;
    std::memcpy(&word, bytes.data() + i, sizeof(Word));
    word = swapped(word);
    std::memcpy(bytes.data() + i, &word, sizeof(Word));
  }
}

/// Converts sign (1 bit), exponent (5), fraction (10) to sign (1), exponent (8), fraction (23).
uint32_t float_bits_of(uint16_t half) {
  const uint32_t sign = uint32_t{half} >> 15 << 31;
  const uint32_t exponent = half >> 10 & 31, fraction = half & 1023;
  if (exponent == 31) return sign | 0x7f800000 | fraction << 13;  // infinity, NaN
  if (exponent > 0) return sign | (exponent + 127 - 15) << 23 | fraction << 13;
  // Zero and subnormal numbers: fraction · 2^-24, which is normal as f32.
  const float value = static_cast<float>(fraction) * 0x1p-24f;
  uint32_t bits;
  std::memcpy(&bits, &value, sizeof bits);
  return sign | bits;
}

}  // namespace

size_t stored_bytes(const StoredVoxels& voxels) {
  return voxels.is_half ? 2 : voxel_bytes(voxels.type);
}

void widen_halves(std::span<const std::byte> halves, std::span<std::byte> out) {
  for (size_t i = 0; i < halves.size() / 2; ++i) {
    uint16_t half;
    std::memcpy(&half, halves.data() + 2 * i, 2);
    const uint32_t bits = float_bits_of(half);
    std::memcpy(out.data() + 4 * i, &bits, 4);
  }
}

void to_native_order(const StoredVoxels& voxels, std::span<std::byte> bytes) {
  if (voxels.big_endian == (std::endian::native == std::endian::big)) return;
  const size_t voxel = stored_bytes(voxels);
  if (voxel == 2) swap_each<uint16_t>(bytes);
  if (voxel == 4) swap_each<uint32_t>(bytes);
  if (voxel == 8) swap_each<uint64_t>(bytes);
}

double stored_number(const StoredVoxels& stored, std::span<const std::byte> bytes) {
  std::vector<std::byte> native(bytes.begin(), bytes.end());
  to_native_order(stored, native);
  if (stored.is_half) {
    std::vector<std::byte> wide(4);
    widen_halves(native, wide);
    native = wide;
  }
  return with_voxel_type(stored.type, [&]<class T>(T value) {
    std::memcpy(&value, native.data(), sizeof value);
    return static_cast<double>(value);
  });
}

}  // namespace isosplat::import
