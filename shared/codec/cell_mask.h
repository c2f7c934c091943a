#pragma once

#include <array>
#include <cstdint>
#include <cstring>

#include "shared/base/vec3.h"
#include "shared/codec/chunk_tables.h"
#include "shared/grid/grid.h"

namespace isosplat {

/// Which cells of a block a chunk holds: a row of bits for each y and z, with a row of zeros before
/// the first of each, so that the neighbours of a first row can be read.
struct CellMask {
  uint64_t bits[kBlockCells + 1][kBlockCells + 1];

  void clear() { std::memset(bits, 0, sizeof bits); }
  uint64_t& row(int32_t y, int32_t z) { return bits[z + 1][y + 1]; }
  uint64_t row(int32_t y, int32_t z) const { return bits[z + 1][y + 1]; }
};

/// The bits of the mask's rows that stand for cells of the block.
inline uint64_t valid_cells(int32_t cells_x) {
  return ~uint64_t{0} >> (64 - cells_x);
}

/// A quad is 2×2 bits at even x and y: bit 0 at (x, y), 1 at (x + 1, y), 2 at (x, y + 1), 3 at
/// (x + 1, y + 1). Its context is made of the bits next to it that come before it:
///
///   bits 0–3  the quad at z − 1        bits 4, 5  (x − 1, y), (x − 1, y + 1)
///                                      bits 6, 7  (x, y − 1), (x + 1, y − 1)
///
/// Start of each quad's slots, from the frequencies in chunk_tables.h.
struct QuadStarts {
  uint16_t brick[256][16];
  uint16_t cell[256][16];

  QuadStarts() {
    for (int context = 0; context < 256; ++context) {
      uint32_t in_bricks = 0, in_cells = 0;
      for (int quad = 0; quad < 16; ++quad) {
        brick[context][quad] = static_cast<uint16_t>(in_bricks);
        cell[context][quad] = static_cast<uint16_t>(in_cells);
        in_bricks += kBrickQuads[context][quad];
        in_cells += kCellQuads[context][quad];
      }
    }
  }
};

/// Which bricks (4×4×4 cells) hold a cell of the chunk; bit x + 1 of a row stands for brick x.
struct BrickMask {
  static constexpr int32_t kAcross = kBlockCells / 4;
  uint32_t bits[kAcross + 1][kAcross + 2] = {};

  uint32_t& row(int32_t y, int32_t z) { return bits[z + 1][y + 1]; }
};

inline BrickMask bricks_of(const CellMask& mask, Index3 cells) {
  BrickMask bricks;
  for (int32_t z = 0; z < cells.z; ++z) {
    for (int32_t y = 0; y < cells.y; ++y) {
      uint64_t row = mask.row(y, z);
      row |= row >> 1;
      row |= row >> 2;
      for (int32_t x = 0; x < cells.x; x += 4) {
        bricks.row(y / 4, z / 4) |= static_cast<uint32_t>(row >> x & 1) << (x / 4 + 1);
      }
    }
  }
  return bricks;
}

/// Codes the bricks, then the cells of each brick that holds any, all in raster order. One text for
/// both directions: `coder.brick(context, quad)` and `coder.cell(context, quad)` return the quad,
/// as given (encoder) or as decoded (decoder, where the masks are clear before); coder.good() may
/// stop it after each brick. Returns whether the bits outside the block are zero, and good() held.
template <class Coder>
bool code_mask(Index3 cells, BrickMask& bricks, CellMask& mask, Coder& coder) {
  const Index3 across{(cells.x + 3) / 4, (cells.y + 3) / 4, (cells.z + 3) / 4};
  for (int32_t z = 0; z < across.z; ++z) {
    for (int32_t y = 0; y < across.y; y += 2) {
      for (int32_t x = 0; x < across.x; x += 2) {
        const auto pair = [&](int32_t row_y, int32_t row_z) {
          return bricks.row(row_y, row_z) >> (x + 1) & 3;
        };
        const uint32_t context = pair(y, z - 1) | pair(y + 1, z - 1) << 2 |
                                 (bricks.row(y, z) >> x & 1) << 4 |
                                 (bricks.row(y + 1, z) >> x & 1) << 5 | pair(y - 1, z) << 6;
        const uint32_t quad = coder.brick(context, pair(y, z) | pair(y + 1, z) << 2);
        bricks.row(y, z) |= (quad & 3) << (x + 1);
        bricks.row(y + 1, z) |= (quad >> 2) << (x + 1);
      }
      const uint32_t outside = ~((2u << across.x) - 1);
      if (((bricks.row(y, z) | bricks.row(y + 1, z)) & outside) != 0 ||
          (y + 1 == across.y && bricks.row(y + 1, z) != 0) || !coder.good()) {
        return false;
      }
    }
  }

  for (int32_t brick_z = 0; brick_z < across.z; ++brick_z) {
    for (int32_t brick_y = 0; brick_y < across.y; ++brick_y) {
      const int32_t y = brick_y * 4;
      for (uint32_t row = bricks.row(brick_y, brick_z) >> 1; row; row &= row - 1) {
        const int32_t x = 4 * __builtin_ctz(row);
        uint32_t below[4];
        for (int i = 0; i < 4; ++i) below[i] = mask.row(y + i, brick_z * 4 - 1) >> x & 15;
        for (int32_t z = brick_z * 4; z < brick_z * 4 + 4 && z < cells.z; ++z) {
          uint32_t old[4], now[4] = {};
          for (int i = 0; i < 4; ++i) old[i] = static_cast<uint32_t>(mask.row(y + i, z) >> x & 15);
          uint32_t above = static_cast<uint32_t>(mask.row(y - 1, z) >> x & 15);
          for (int j = 0; j < 4 && y + j < cells.y; j += 2) {
            uint32_t left0 = static_cast<uint32_t>(mask.row(y + j, z) << 1 >> x & 1);
            uint32_t left1 = static_cast<uint32_t>(mask.row(y + j + 1, z) << 1 >> x & 1);
            for (int i = 0; i < 4 && x + i < cells.x; i += 2) {
              const uint32_t context = (below[j] >> i & 3) | (below[j + 1] >> i & 3) << 2 |
                                       left0 << 4 | left1 << 5 | (above >> i & 3) << 6;
              const uint32_t quad =
                  coder.cell(context, (old[j] >> i & 3) | (old[j + 1] >> i & 3) << 2);
              now[j] |= (quad & 3) << i;
              now[j + 1] |= (quad >> 2) << i;
              left0 = quad >> 1 & 1;
              left1 = quad >> 3 & 1;
            }
            above = now[j + 1];
          }
          for (int i = 0; i < 4; ++i) {
            mask.row(y + i, z) |= static_cast<uint64_t>(now[i]) << x;
            below[i] = now[i];
          }
        }
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
