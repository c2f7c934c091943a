#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <span>

#include "shared/core/base/vec3.h"
#include "shared/core/codec/chunk_tables.h"
#include "shared/core/grid/grid.h"

namespace isosplat {

/// The cells of a block that a chunk holds: a row of bits for each y and z. A row of zeros precedes
/// the first row along y and z, so that each row has readable neighbours.
struct CellMask {
  uint64_t bits[kBlockCells + 1][kBlockCells + 1];

  void clear() { std::memset(bits, 0, sizeof bits); }
  uint64_t& row(int32_t y, int32_t z) { return bits[z + 1][y + 1]; }
  uint64_t row(int32_t y, int32_t z) const { return bits[z + 1][y + 1]; }

  /// Sets the cells to those of a list (x | y << 6 | z << 12). False, with an undefined mask,
  /// unless the list ascends within a block of this size.
  bool set(std::span<const uint32_t> cells, Index3 block_cells) {
    clear();
    uint32_t least = 0;
    for (const uint32_t cell : cells) {
      const auto x = static_cast<int32_t>(cell & 63), y = static_cast<int32_t>(cell >> 6 & 63);
      const auto z = static_cast<int32_t>(cell >> 12);
      if (cell < least || x >= block_cells.x || y >= block_cells.y || z >= block_cells.z) {
        return false;
      }
      least = cell + 1;
      row(y, z) |= uint64_t{1} << x;
    }
    return true;
  }

  /// The cells of brick (x, y, z), in bricks: bit x + 4 y + 16 z.
  uint64_t brick(int32_t x, int32_t y, int32_t z) const {
    uint64_t word = 0;
    for (int i = 0; i < 16; ++i) {
      word |= (row(4 * y + (i & 3), 4 * z + (i >> 2)) >> (4 * x) & 15) << (4 * i);
    }
    return word;
  }
  /// Adds the cells of a brick.
  void set_brick(int32_t x, int32_t y, int32_t z, uint64_t word) {
    const uint64_t nibble = uint64_t{15} << (4 * x), turned = std::rotl(word, 4 * x);
    for (int i = 0; i < 16; ++i) {
      row(4 * y + (i & 3), 4 * z + (i >> 2)) |= std::rotr(turned, 4 * i) & nibble;
    }
  }
};

/// The bits of a row that correspond to cells of the block.
inline uint64_t valid_cells(int32_t cells_x) {
  return ~uint64_t{0} >> (64 - cells_x);
}

/// A quad is 2×2 bits at even x and y: bit 0 at (x, y), 1 at (x + 1, y), 2 at (x, y + 1), 3 at
/// (x + 1, y + 1). Its context consists of the neighbouring bits that were coded before:
///
///   bits 0–3  the quad at z − 1        bits 4, 5  (x − 1, y), (x − 1, y + 1)
///                                      bits 6, 7  (x, y − 1), (x + 1, y − 1)
///
/// The slots of each quad, of kQuadTotal, by context.
struct QuadSlots {
  uint16_t start[256][16];
  uint16_t frequency[256][16];

  QuadSlots() {
    for (int context = 0; context < 256; ++context) {
      read_distribution(kQuadTable[context], 16, kQuadTotal, frequency[context]);
      uint32_t next = 0;
      for (int quad = 0; quad < 16; ++quad) {
        start[context][quad] = static_cast<uint16_t>(next);
        next += frequency[context][quad];
      }
    }
  }
};

/// The bricks (4×4×4 cells) that hold a cell of the chunk; bit x + 1 of a row is brick x.
struct BrickMask {
  static constexpr int32_t kAcross = kBlockCells / 4;
  uint32_t bits[kAcross + 1][kAcross + 2] = {};

  uint32_t& row(int32_t y, int32_t z) { return bits[z + 1][y + 1]; }
};

inline BrickMask bricks_of(const CellMask& mask, Index3 cells) {
  BrickMask bricks;
  for (int32_t z = 0; z < cells.z; ++z) {
    for (int32_t y = 0; y < cells.y; ++y) {
      // Reduces each four bits to one bit, then moves these bits together.
      uint64_t row = mask.row(y, z);
      row |= row >> 1;
      row = (row | row >> 2) & 0x1111111111111111;
      row = (row | row >> 3) & 0x0303030303030303;
      row = (row | row >> 6) & 0x000f000f000f000f;
      row = (row | row >> 12) & 0x000000ff000000ff;
      row = (row | row >> 24) & 0xffff;
      bricks.row(y / 4, z / 4) |= static_cast<uint32_t>(row << 1);
    }
  }
  return bricks;
}

/// Converts the cells of a brick from raster order (bit x + 4 y + 16 z) to the order of quads, four
/// bits each, or back.
inline uint64_t swap_quads(uint64_t word) {
  const uint64_t differ = (word ^ word >> 2) & 0x0c0c0c0c0c0c0c0c;
  return word ^ differ ^ differ << 2;
}

/// Codes a brick's quads; see code_mask(). left, above, below: the words of the bricks before it
/// along x, y, z; old: the word of the brick itself, when encoding; all in the order of quads.
template <class Coder>
inline uint64_t code_brick(Coder& coder, int32_t slices, bool two_x, bool two_y, uint64_t left,
                           uint64_t above, uint64_t below, uint64_t old) {
  const auto bits = [](uint64_t word, int from) { return static_cast<uint32_t>(word >> from); };
  const auto right_of = [](uint32_t quad) { return (quad & 2) << 3 | (quad & 8) << 2; };
  // The four quads of a slice are separate variables, so that a quad depends only on the quads in
  // its context.
  uint32_t q0 = bits(below, 48) & 15, q1 = bits(below, 52) & 15;
  uint32_t q2 = bits(below, 56) & 15, q3 = bits(below, 60) & 15;
  Coder local = coder;  // in registers
  uint64_t word = 0;
  // Most bricks have both columns and both rows of quads. Then each slice uses each of the four
  // coder states once, and no state moves between registers.
  const auto code_slices = [&](bool with_x, bool with_y) __attribute__((always_inline)) {
    for (int32_t z = 0; z < 16 * slices; z += 16) {
      const uint32_t side = bits(left, z), up = bits(above, z), quads = bits(old, z);
      q0 = local.quad(q0 | right_of(side >> 4) | (up >> 4 & 0xc0), quads & 15);
      if (with_x) q1 = local.quad(q1 | right_of(q0) | (up >> 8 & 0xc0), quads >> 4 & 15);
      if (with_y) q2 = local.quad(q2 | right_of(side >> 12) | (q0 << 4 & 0xc0), quads >> 8 & 15);
      if (with_x && with_y) {
        q3 = local.quad(q3 | right_of(q2) | (q1 << 4 & 0xc0), quads >> 12 & 15);
      }
      word |= uint64_t{q0 | q1 << 4 | q2 << 8 | q3 << 12} << z;
    }
  };
  if (two_x && two_y) {
    code_slices(true, true);
  } else {
    code_slices(two_x, two_y);
  }
  coder = local;
  return word;
}

/// Codes the bricks, then the cells of each brick that holds any, all in raster order. Encoder and
/// decoder share this function: `coder.quad(context, quad)` returns the given quad (encoder) or the
/// decoded one (decoder, which begins with empty masks). Stops after a brick if coder.good() is
/// false. Returns whether the bits outside the block are zero and good() was always true.
template <class Coder, class Mask>
bool code_mask(Index3 cells, BrickMask& bricks, Mask& mask, Coder& coder) {
  const Index3 across{(cells.x + 3) / 4, (cells.y + 3) / 4, (cells.z + 3) / 4};
  for (int32_t z = 0; z < across.z; ++z) {
    for (int32_t y = 0; y < across.y; y += 2) {
      Coder local = coder;  // in registers
      for (int32_t x = 0; x < across.x; x += 2) {
        const auto pair = [&](int32_t row_y, int32_t row_z) {
          return bricks.row(row_y, row_z) >> (x + 1) & 3;
        };
        const uint32_t context = pair(y, z - 1) | pair(y + 1, z - 1) << 2 |
                                 (bricks.row(y, z) >> x & 1) << 4 |
                                 (bricks.row(y + 1, z) >> x & 1) << 5 | pair(y - 1, z) << 6;
        const uint32_t quad = local.quad(context, pair(y, z) | pair(y + 1, z) << 2);
        bricks.row(y, z) |= (quad & 3) << (x + 1);
        bricks.row(y + 1, z) |= (quad >> 2) << (x + 1);
      }
      coder = local;
      const uint32_t outside = ~((2u << across.x) - 1);
      if (((bricks.row(y, z) | bricks.row(y + 1, z)) & outside) != 0 ||
          (y + 1 == across.y && bricks.row(y + 1, z) != 0) || !coder.good()) {
        return false;
      }
    }
  }

  // Bricks in the order of quads: two planes of them, with zeros before the first.
  constexpr int32_t kPadded = BrickMask::kAcross + 1;
  uint64_t words[2][kPadded][kPadded] = {};
  for (int32_t z = 0; z < across.z; ++z) {
    auto &current = words[z & 1], &previous = words[~z & 1];
    std::memset(current, 0, sizeof current);
    const int32_t slices = cells.z - 4 * z < 4 ? cells.z - 4 * z : 4;
    for (int32_t y = 0; y < across.y; ++y) {
      const bool two_y = 4 * y + 2 < cells.y;
      for (uint32_t row = bricks.row(y, z) >> 1; row; row &= row - 1) {
        const int32_t x = __builtin_ctz(row);
        const bool two_x = 4 * x + 2 < cells.x;
        const uint64_t old = Coder::kDecodes ? 0 : swap_quads(mask.brick(x, y, z));
        const uint64_t word = code_brick(coder, slices, two_x, two_y, current[y + 1][x],
                                         current[y][x + 1], previous[y + 1][x + 1], old);
        current[y + 1][x + 1] = word;
        if constexpr (Coder::kDecodes) mask.set_brick(x, y, z, swap_quads(word));
        if (!coder.good()) return false;
      }
    }
  }

  const uint64_t valid = valid_cells(cells.x);
  uint64_t outside = 0;
  for (int32_t z = 0; z < cells.z; ++z) {
    for (int32_t y = 0; y < across.y * 4; ++y) {
      outside |= mask.row(y, z) & (y < cells.y ? ~valid : ~uint64_t{0});
    }
  }
  return outside == 0;
}

}  // namespace isosplat
