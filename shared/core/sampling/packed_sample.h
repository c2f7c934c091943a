#pragma once

#include <cstdint>

#include "shared/core/sampling/cell.h"

namespace isosplat {

/// A sample as the GPU reads it: the cell's index, interval and corners in 16 bytes. The vertex
/// shader computes the value, the gradient and everything else from the corners.
///
///   word 0   bits  0–5   x of the cell in its block        word 1   bits  0–15  interval min
///                  6–11  y                                          bits 16–31  interval max
///                 12–17  z                                 word 2   low 8 bits of corners 0 to 3
///                 18–21  neighbour bits 0 to 3             word 3   low 8 bits of corners 4 to 7
///                 22–29  ninth bits of corners 0 to 7      (corner i is byte i & 3 of its word)
///                 30–31  neighbour bits 4 and 5
///
/// Neighbour bits are those of sample_neighbours.h at coarse levels, and 0 otherwise.
///
/// A corner is held as q = (clamp(corner, min, max) − min) >> shift, nine bits, where
/// shift = max(0, bit_width(max − min) − 9). It is read back as min + (q << shift) + (1 << shift >>
/// 1). That is exact for spans below 512 quantized values, so always for 8-bit volumes, and within
/// 1/512 of the cell's span otherwise. min and max are always exact, so CPU and GPU find the
/// same cells active.
struct PackedSample {
  uint32_t word[4];

  /// Uninitialised, so that resizing a vector that is then overwritten costs no extra writes.
  PackedSample() {}

  friend constexpr bool operator==(const PackedSample&, const PackedSample&) = default;
};
static_assert(sizeof(PackedSample) == 16);

/// The content of a PackedSample.
struct UnpackedSample {
  Index3 cell;  ///< in the block
  CellInterval interval;
  std::array<float, 8> corners;  ///< quantized values
};

/// The shift by which corners of a cell with this interval are packed, 0 to 7.
int corner_shift(CellInterval interval);

/// Packs a cell. `cell` is in its block, each 0 to 63. The interval is not empty: min ≤ max.
PackedSample pack_sample(Index3 cell, CellInterval interval, const CellCorners& corners);

/// Safe for any 16 bytes, valid or not.
UnpackedSample unpack_sample(const PackedSample& packed);

}  // namespace isosplat
