#pragma once

#include <algorithm>
#include <cstdint>

#include "shared/codec/cell_mask.h"
#include "shared/codec/chunk_tables.h"
#include "shared/codec/simd.h"

namespace isosplat {

/// The voxels at the corners of a chunk's cells form a sparse lattice of (cells + 1)³ points, coded
/// row by row. A row that has any point is held dense: what is absent is filled from the rows
/// before, so that every neighbour of a point has a value, and prediction needs no branch.
inline constexpr int32_t kLatticeAcross = kBlockCells + 1;

/// Room before point 0 and after point 64, for neighbours and whole vectors.
inline constexpr int32_t kRowPad = 8;
inline constexpr int32_t kRowSize = 80;

/// A row's values, as code − 32768 so that they fit signed arithmetic.
struct ValueRow {
  int16_t at[kRowSize];
};

/// How far each point of a row was from its prediction, at most kMaxEnergy.
struct EnergyRow {
  int16_t at[kRowSize];
};
inline constexpr int32_t kMaxEnergy = 4095;  // eight of them fit in 15 bits

/// Which points a row has: bits 0–63 and point 64.
struct PointMask {
  uint64_t word[2];

  bool any() const { return (word[0] | word[1]) != 0; }
  uint32_t count() const {
    return static_cast<uint32_t>(__builtin_popcountll(word[0])) + static_cast<uint32_t>(word[1]);
  }
  PointMask shifted_up() const { return {{word[0] << 1, word[0] >> 63}}; }
};

/// The points of row (y, z) of the lattice: the corners of up to four rows of cells. Rows of cells
/// outside the block count as empty.
inline PointMask points_of_row(const CellMask& mask, Index3 cells, int32_t y, int32_t z) {
  uint64_t touched = 0;
  if (z < cells.z) touched |= mask.row(y - 1, z) | (y < cells.y ? mask.row(y, z) : 0);
  if (z > 0) touched |= mask.row(y - 1, z - 1) | (y < cells.y ? mask.row(y, z - 1) : 0);
  return {{touched | touched << 1, touched >> 63}};
}

/// One plane of the lattice, z constant.
struct PointPlane {
  PointMask points[kLatticeAcross];

  /// Returns the number of points.
  uint32_t set(const CellMask& mask, Index3 cells, int32_t z) {
    uint32_t count = 0;
    for (int32_t y = 0; y <= cells.y; ++y) {
      points[y] = points_of_row(mask, cells, y, z);
      count += points[y].count();
    }
    return count;
  }
  void clear() {
    for (PointMask& row : points) row = {};
  }
};

/// A row's values and energies.
struct RowPointers {
  const int16_t* value;
  const int16_t* energy;
};

/// The rows that stand for those around row (y, z): (y − 1, z), (y, z − 1), (y + 1, z − 1) and
/// (y − 1, z − 1).
struct Neighbours {
  RowPointers up, back, back_down, back_up;
};

/// A neighbouring row without a point has no values: another stands in, the same on both sides.
/// `current`, `previous`: the planes z and z − 1 (without points where z = 0); `row(plane, y)` the
/// rows' data (plane 0 current, 1 previous); `last` the row coded most recently.
template <class Row>
Neighbours neighbours_of(const PointPlane& current, const PointPlane& previous, int32_t y,
                         int32_t last_y, Row row, RowPointers last) {
  const bool up = y > 0 && current.points[y - 1].any();
  const bool back = previous.points[y].any();
  const bool back_up = y > 0 && previous.points[y - 1].any();
  const bool back_down = y < last_y && previous.points[y + 1].any();
  Neighbours n;
  if (up && back) {
    n.up = row(0, y - 1), n.back = row(1, y);
    n.back_up = back_up ? row(1, y - 1) : n.up;
  } else if (up || back) {
    n.up = n.back = n.back_up = up ? row(0, y - 1) : row(1, y);
  } else {
    n.up = n.back = back_up ? row(1, y - 1) : back_down ? row(1, y + 1) : last;
    n.back_up = n.up;
  }
  n.back_down = back_down ? row(1, y + 1) : n.back;
  return n;
}

/// Fills a row before its points are set: up + back − back_up, kept between up and back.
inline void fill_values(const Neighbours& n, int16_t* row) {
  row[-1] = row[-2] = n.up.value[0];
  for (int x = 0; x < kBlockCells + kRowPad; ++x) {
    const int16_t up = n.up.value[x], back = n.back.value[x];
    const int16_t low = std::min(up, back), high = std::max(up, back);
    const int16_t middle = std::min(std::max(n.back_up.value[x], low), high);
    row[x] = static_cast<int16_t>(low + high - middle);
  }
}

inline void fill_energies(const Neighbours& n, int16_t* row) {
  row[-1] = n.up.energy[0];
  for (int x = 0; x < kBlockCells + kRowPad; ++x) {
    row[x] = static_cast<int16_t>((n.up.energy[x] + n.back.energy[x]) >> 1);
  }
}

/// What stands in for the rows before the first one: the middle of the slab.
inline void set_first_row(uint32_t slab_begin, uint32_t slab_end, ValueRow& value,
                          EnergyRow& energy) {
  const auto middle = static_cast<int32_t>((slab_begin + slab_end) / 2);
  std::fill_n(value.at, kRowSize, static_cast<int16_t>(std::min(middle, 65535) - 32768));
  std::fill_n(energy.at, kRowSize, int16_t{4});
}

/// After a row's points are set: the points beyond the block repeat the last one.
inline void pad_row(int16_t* row, int32_t last_x) {
  row[last_x + 1] = row[last_x + 2] = row[last_x];
}

/// A point's class says which of its neighbours are points too: bit 0 (x − 1, y, z),
/// 1 (x, y − 1, z), 2 (x, y, z − 1), 3 (x, y − 1, z − 1).
struct ClassBits {
  uint64_t left, up, back, back_up;

  uint32_t at(int bit) const {
    return static_cast<uint32_t>((left >> bit & 1) | (up >> bit & 1) << 1 | (back >> bit & 1) << 2 |
                                 (back_up >> bit & 1) << 3);
  }
};

inline ClassBits class_bits(const PointPlane& current, const PointPlane& previous, int32_t y,
                            int word) {
  return {current.points[y].shifted_up().word[word], y > 0 ? current.points[y - 1].word[word] : 0,
          previous.points[y].word[word], y > 0 ? previous.points[y - 1].word[word] : 0};
}

/// The classes' predictors: weights in 1/128 of 14 neighbours (taps), in the order
///
///   0–2  (x − 1, x, x + 1) of (y − 1, z)        9–11  of (y − 1, z − 1)
///   3–5  of (y, z − 1)                          12    (x − 1, y, z)
///   6–8  of (y + 1, z − 1)                      13    (x − 2, y, z)
///
/// They sum to 128. Tap 1 is not coded: it is what the others leave.
inline constexpr int kImpliedTap = 1;
inline constexpr int kWeightBits = 7;
inline constexpr int32_t kMaxWeight = 1023;

struct ClassWeights {
  int16_t rows[16] = {};  ///< taps 0–11, each three followed by a zero
  int32_t left = 0;
  int32_t left2 = 0;

  void set(const int32_t* taps) {
    for (int i = 0; i < 12; ++i) rows[i / 3 * 4 + i % 3] = static_cast<int16_t>(taps[i]);
    left = taps[12];
    left2 = taps[13];
  }
};

struct Predictor {
  ClassWeights classes[kClasses];
  int32_t greatest = 32767;  ///< of a prediction, less 32768; the least is −32768

  /// `row` points at x in the row itself.
  int32_t predict(const ClassWeights& weights, int32_t sum, const int16_t* row) const {
    const int32_t scaled = sum + weights.left * row[-1] + weights.left2 * row[-2];
    return std::clamp((scaled + (1 << (kWeightBits - 1))) >> kWeightBits, -32768, greatest);
  }
};

inline TapPointers taps_at(const Neighbours& n, int32_t x) {
  return {n.up.value + x - 1,      n.back.value + x - 1, n.back_down.value + x - 1,
          n.back_up.value + x - 1, n.up.energy + x - 1,  n.back.energy + x - 1};
}

}  // namespace isosplat
