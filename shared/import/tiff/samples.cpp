#include "shared/import/tiff/samples.h"

#include <algorithm>
#include <cstring>

#include "shared/import/voxels/stored_voxels.h"

namespace isosplat::import {
namespace {

/// The `bits` bits of a row from bit `at` on, the highest first.
uint64_t packed_bits(std::span<const std::byte> row, size_t at, unsigned bits) {
  uint64_t value = 0;
  for (unsigned left = bits; left > 0;) {
    const unsigned skipped = at % 8, taken = std::min(8 - skipped, left);
    const unsigned byte = std::to_integer<unsigned>(row[at / 8]);
    value = value << taken | (byte >> (8 - skipped - taken) & ((1u << taken) - 1));
    at += taken;
    left -= taken;
  }
  return value;
}

/// Converts sign (1 bit), exponent (7), fraction (16) to sign (1), exponent (8), fraction (23).
uint32_t float_bits_of_24(uint32_t value) {
  const uint32_t sign = value >> 23 << 31, exponent = value >> 16 & 127, fraction = value & 0xffff;
  if (exponent == 127) return sign | 0x7f800000 | fraction << 7;  // infinity, NaN
  if (exponent > 0) return sign | (exponent + 127 - 63) << 23 | fraction << 7;
  // Zero and subnormal numbers: fraction · 2^-78, which is normal as f32.
  const float small = static_cast<float>(fraction) * 0x1p-78f;
  uint32_t bits;
  std::memcpy(&bits, &small, sizeof bits);
  return sign | bits;
}

uint32_t three_bytes(const std::byte* from) {
  uint32_t value = 0;
  std::memcpy(&value, from, 3);  // this machine and WebAssembly are little-endian
  return value;
}

}  // namespace

void unpack_row(const TiffSamples& samples, unsigned sample, std::span<const std::byte> row,
                VoxelType type, std::span<std::byte> voxels) {
  const size_t voxel = voxel_bytes(type), pixels = voxels.size() / voxel;
  const unsigned bits = samples.bits, per_pixel = samples.per_pixel;
  if (bits == 8 || bits == 16 || bits == 24 || bits == 32 || bits == 64) {
    const size_t bytes = bits / 8;
    for (size_t i = 0; i < pixels; ++i) {
      const std::byte* from = row.data() + (i * per_pixel + sample) * bytes;
      std::byte* to = voxels.data() + i * voxel;
      if (samples.is_float && bits == 16) {
        widen_halves({from, 2}, {to, 4});
      } else if (bits == 24) {
        uint32_t value = three_bytes(from);
        if (samples.is_float) value = float_bits_of_24(value);
        if (samples.is_signed && (value & 0x800000) != 0) value |= 0xff000000;
        std::memcpy(to, &value, 4);
      } else {
        std::memcpy(to, from, bytes);
      }
    }
    return;
  }
  for (size_t i = 0; i < pixels; ++i) {
    uint64_t value = packed_bits(row, (i * per_pixel + sample) * bits, bits);
    const bool is_negative = samples.is_signed && (value >> (bits - 1) & 1) != 0;
    if (is_negative) value |= ~uint64_t{0} << bits;
    std::memcpy(voxels.data() + i * voxel, &value, voxel);
  }
}

}  // namespace isosplat::import
