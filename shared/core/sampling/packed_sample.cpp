#include "shared/core/sampling/packed_sample.h"

#include <bit>

namespace isosplat {

int corner_shift(CellInterval interval) {
  if (interval.min >= interval.max) return 0;
  const auto span = static_cast<uint32_t>(interval.max - interval.min);
  return std::max(0, static_cast<int>(std::bit_width(span)) - 9);
}

PackedSample pack_sample(Index3 cell, CellInterval interval, const CellCorners& corners) {
  const int shift = corner_shift(interval);
  PackedSample packed;
  packed.word[0] = static_cast<uint32_t>(cell.x | cell.y << 6 | cell.z << 12);
  packed.word[1] = static_cast<uint32_t>(interval.min) | static_cast<uint32_t>(interval.max) << 16;
  packed.word[2] = packed.word[3] = 0;
  for (int i = 0; i < 8; ++i) {
    const QuantizedValue clamped = std::clamp(corners[i], interval.min, interval.max);
    const uint32_t q = static_cast<uint32_t>(clamped - interval.min) >> shift;
    packed.word[0] |= (q >> 8) << (22 + i);
    packed.word[2 + i / 4] |= (q & 255) << (8 * (i & 3));
  }
  return packed;
}

UnpackedSample unpack_sample(const PackedSample& packed) {
  const uint32_t w = packed.word[0];
  UnpackedSample sample;
  sample.cell = {static_cast<int32_t>(w & 63), static_cast<int32_t>(w >> 6 & 63),
                 static_cast<int32_t>(w >> 12 & 63)};
  sample.interval = {static_cast<QuantizedValue>(packed.word[1] & 0xffff),
                     static_cast<QuantizedValue>(packed.word[1] >> 16)};
  const int shift = corner_shift(sample.interval);
  for (int i = 0; i < 8; ++i) {
    const uint32_t q = (packed.word[2 + i / 4] >> (8 * (i & 3)) & 255) | (w >> (22 + i) & 1) << 8;
    sample.corners[i] =
        static_cast<float>(sample.interval.min + (q << shift) + ((1u << shift) >> 1));
  }
  return sample;
}

}  // namespace isosplat
