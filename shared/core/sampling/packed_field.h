#pragma once

#include <cstdint>

#include "shared/core/sampling/cell.h"

namespace isosplat {

/// The values of a field at the corners of a sample's cell, as the GPU reads them beside the
/// PackedSample: corner c is bits 16 · (c & 1) to 16 · (c & 1) + 15 of word[c >> 1]. They are
/// quantized values of the field, and exact.
struct PackedField {
  uint32_t word[4];

  /// Uninitialised, so that resizing a vector that is then overwritten costs no extra writes.
  PackedField() {}

  friend constexpr bool operator==(const PackedField&, const PackedField&) = default;
};
static_assert(sizeof(PackedField) == 16);

inline PackedField pack_field(const CellCorners& corners) {
  PackedField packed;
  for (uint32_t i = 0; i < 4; ++i) {
    packed.word[i] = corners[2 * i] | uint32_t{corners[2 * i + 1]} << 16;
  }
  return packed;
}

}  // namespace isosplat
