#pragma once

#include <cstdint>

#include "shared/core/codec/lattice.h"
#include "shared/core/codec/simd.h"
#include "shared/core/sampling/packed_sample.h"

namespace isosplat {

/// The intervals of a row of cells, by x, with room for whole vectors.
struct IntervalRow {
  QuantizedValue min[kBlockCells + 8] = {};
  QuantizedValue max[kBlockCells + 8] = {};
};

/// Writes the packed samples of a row's cells, in the order of x, and returns the end of them. May
/// overwrite up to kPackedSlack samples after the end. cells: bit x is set if the chunk has cell x;
/// row_cell: y << 6 | z << 12; intervals: null if each cell's interval is that of its corners.
inline constexpr int kPackedSlack = 7;

inline PackedSample* pack_cells_scalar(uint64_t cells, uint32_t row_cell, const CellRows& rows,
                                       const IntervalRow* intervals, PackedSample* to) {
  for (; cells; cells &= cells - 1) {
    const int32_t x = __builtin_ctzll(cells);
    const CellCorners corners = rows.corners(x);
    *to++ = pack_sample(
        {x, static_cast<int32_t>(row_cell >> 6 & 63), static_cast<int32_t>(row_cell >> 12)},
        intervals ? CellInterval{intervals->min[x], intervals->max[x]} : corner_interval(corners),
        corners);
  }
  return to;
}

#if ISOSPLAT_CODEC_SIMD
/// Handles windows of eight adjacent cells, each of which begins with a cell of the chunk. Vectors
/// have a 16-bit lane per cell; a transposition at the end makes samples of them.
inline PackedSample* pack_cells(uint64_t cells, uint32_t row_cell, const CellRows& rows,
                                const IntervalRow* intervals, PackedSample* to) {
  using namespace simd;
  const V flip = splat16(0x8000), bytes = splat16(255);
  while (cells) {
    const int32_t x = __builtin_ctzll(cells);
    const auto window = static_cast<uint32_t>(cells >> x & 255);
    cells &= ~(uint64_t{255} << x);

    V corner[8] = {load(rows.r00 + x),     load(rows.r00 + x + 1), load(rows.r10 + x),
                   load(rows.r10 + x + 1), load(rows.r01 + x),     load(rows.r01 + x + 1),
                   load(rows.r11 + x),     load(rows.r11 + x + 1)};
    V min = corner[0], max = corner[0];
    for (int i = 1; i < 8; ++i) min = min_s16(min, corner[i]), max = max_s16(max, corner[i]);
    if (intervals) {
      min = xor_(load(intervals->min + x), flip), max = xor_(load(intervals->max + x), flip);
      for (V& c : corner) c = max_s16(min_s16(c, max), min);
    }
    for (V& c : corner) c = sub16(c, min);

    V span = sub16(max, min), ninth = splat16(0);
    if (any_above_u16(span, 255)) {
      // corner_shift() of each lane by bisection: how many bits the span has beyond nine. All lanes
      // of more bits shift at once.
      for (uint32_t shift = 4; shift > 0; shift /= 2) {
        if (!any_above_u16(span, (256u << shift) - 1)) continue;
        const V wide = above_u16(span, (256u << shift) - 1);
        for (V& c : corner) c = select(c, shift_right_u16(c, shift), wide);
        span = select(span, shift_right_u16(span, shift), wide);
      }
      for (int i = 0; i < 8; ++i) {
        ninth = or_(ninth, shift_left_u16(shift_right_u16(corner[i], 8), static_cast<uint32_t>(i)));
        corner[i] = and_(corner[i], bytes);
      }
    }

    V pair[4];
    for (int i = 0; i < 4; ++i) {
      pair[i] = or_(corner[2 * i], shift_left_u16(corner[2 * i + 1], 8));
    }
    const V first = splat32(row_cell + static_cast<uint32_t>(x)), word1_low = xor_(min, flip),
            word1_high = xor_(max, flip);
    const auto transpose = [&](int at, V word0, V word1, V word2, V word3) {
      const V low01 = low_halves32(word0, word1), low23 = low_halves32(word2, word3);
      const V high01 = high_halves32(word0, word1), high23 = high_halves32(word2, word3);
      const V samples[4] = {low_halves64(low01, low23), high_halves64(low01, low23),
                            low_halves64(high01, high23), high_halves64(high01, high23)};
      for (int i = 0; i < 4; ++i) {
        store(to, samples[i]);
        to += window >> (at + i) & 1;
      }
    };
    const V zero = splat16(0);
    transpose(0, or_(add32(first, set4(0, 1, 2, 3)), shift_left_u32(low_halves16(ninth, zero), 22)),
              low_halves16(word1_low, word1_high), low_halves16(pair[0], pair[1]),
              low_halves16(pair[2], pair[3]));
    transpose(4,
              or_(add32(first, set4(4, 5, 6, 7)), shift_left_u32(high_halves16(ninth, zero), 22)),
              high_halves16(word1_low, word1_high), high_halves16(pair[0], pair[1]),
              high_halves16(pair[2], pair[3]));
  }
  return to;
}
#else
inline PackedSample* pack_cells(uint64_t cells, uint32_t row_cell, const CellRows& rows,
                                const IntervalRow* intervals, PackedSample* to) {
  return pack_cells_scalar(cells, row_cell, rows, intervals, to);
}
#endif

}  // namespace isosplat
