#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "shared/core/codec/cell_mask.h"
#include "shared/core/codec/chunk_tables.h"
#include "shared/core/codec/ops.h"
#include "shared/core/codec/residual_model.h"

namespace isosplat {

/// The voxels at the corners of a chunk's cells are the points of a sparse lattice of (cells + 1)³
/// positions. Points are coded row by row. A row that has any point gets a value at every position:
/// positions without a point are filled from the rows before. So every neighbour of a point has a
/// value, and prediction needs no branch.
inline constexpr int32_t kLatticeAcross = kBlockCells + 1;

/// Positions before 0 and after 64, so that neighbours and whole vectors can be read there.
inline constexpr int32_t kRowPad = 4;
inline constexpr int32_t kRowSize = 86;

/// A row's values, as quantized value − 32768 so that they fit signed arithmetic.
struct Row {
  int16_t value[kRowSize];
};

/// The values at the corners of a row of cells: the lattice's rows (y, z), (y + 1, z), (y, z + 1)
/// and (y + 1, z + 1), each from position 0 on.
struct CellRows {
  const int16_t *r00, *r10, *r01, *r11;

  CellRows(const Row& row00, const Row& row10, const Row& row01, const Row& row11)
      : r00(row00.value + kRowPad),
        r10(row10.value + kRowPad),
        r01(row01.value + kRowPad),
        r11(row11.value + kRowPad) {}

  CellCorners corners(int32_t x) const {
    const auto quantized = [](int16_t value) {
      return static_cast<QuantizedValue>(value ^ -0x8000);
    };
    return {quantized(r00[x]), quantized(r00[x + 1]), quantized(r10[x]), quantized(r10[x + 1]),
            quantized(r01[x]), quantized(r01[x + 1]), quantized(r11[x]), quantized(r11[x + 1])};
  }
};

/// The positions of a row that have points: 0–63 in word[0], 64 in word[1].
struct PointMask {
  uint64_t word[2];

  bool any() const { return (word[0] | word[1]) != 0; }
  bool has(int32_t x) const { return (word[x >> 6] >> (x & 63) & 1) != 0; }
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

/// The rows from which row (y, z) is predicted: up is (y − 1, z), back (y, z − 1), back_down
/// (y + 1, z − 1), and back_up (y − 1, z − 1), or substitutes for them.
struct Neighbours {
  const Row *up, *back, *back_down, *back_up;
};

/// The neighbours of row y. A row without a point has no values: encoder and decoder substitute the
/// same other row. current, previous: the planes z and z − 1 (without points if z = 0). row(plane,
/// y) returns a row (plane 0: current, 1: previous). last: the row coded most recently.
template <class RowAt>
Neighbours neighbours_of(const PointPlane& current, const PointPlane& previous, int32_t y,
                         int32_t last_y, RowAt row, const Row* last) {
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

/// Fills a row before its points are set: up + back − back_up, clamped to the range between up and
/// back.
inline void fill_values(const Neighbours& n, Row& to) {
  const auto fill = [](int16_t* __restrict row, const int16_t* __restrict up,
                       const int16_t* __restrict back, const int16_t* __restrict back_up) {
    for (int x = kRowPad; x < kRowPad + kBlockCells + 16; ++x) {
      const int16_t low = up[x] < back[x] ? up[x] : back[x];
      const int16_t high = up[x] < back[x] ? back[x] : up[x];
      const int16_t above = back_up[x] < low ? low : back_up[x];
      const int16_t middle = above < high ? above : high;
      row[x] = static_cast<int16_t>(low + high - middle);
    }
  };
  to.value[kRowPad - 1] = to.value[kRowPad - 2] = n.up->value[kRowPad];
  fill(to.value, n.up->value, n.back->value, n.back_up->value);
}

/// Sets the substitute for the rows before the first one: the middle of the band.
inline void set_first_row(uint32_t band_begin, uint32_t band_end, Row& row) {
  const auto middle = static_cast<int32_t>((band_begin + band_end) / 2);
  std::fill_n(row.value, kRowSize, static_cast<int16_t>(std::min(middle, 65535) - 32768));
}

/// Repeats the last value of a row beyond the block, after the row's points are set.
inline void pad_row(Row& row, int32_t last_x) {
  int16_t* last = row.value + kRowPad + last_x;
  last[1] = last[2] = last[0];
}

/// The magnitude of the most recent residual at each (x, y), in any earlier plane: at most
/// kMaxEnergy; kFirstEnergy where no point was yet. The contexts of a plane's residuals depend on
/// earlier planes only, so that one loop decodes all residuals of a plane.
inline constexpr int32_t kMaxEnergy = 4095;
inline constexpr int16_t kFirstEnergy = 4;
struct Energies {
  static constexpr int32_t kStride = 88;
  int16_t values[kLatticeAcross + 2][kStride];

  void reset() { std::fill_n(&values[0][0], sizeof values / sizeof(int16_t), kFirstEnergy); }
  /// The energies of row y, by x.
  int16_t* row(int32_t y) { return &values[y + 1][1]; }
  void set(int32_t x, int32_t y, int32_t residual) { row(y)[x] = energy_of(residual); }
  static int16_t energy_of(int32_t residual) {
    const int32_t magnitude = residual < 0 ? -residual : residual;
    return static_cast<int16_t>(magnitude < kMaxEnergy ? magnitude : kMaxEnergy);
  }

  /// The rows y − 1, y and y + 1.
  EnergyRows around(int32_t y) const { return {values[y], values[y + 1], values[y + 2]}; }
};

/// A point's class states which of its neighbours are points too: bit 0 (x − 1, y, z),
/// 1 (x, y − 1, z), 2 (x, y, z − 1), 3 (x, y − 1, z − 1).
inline constexpr uint32_t kLeftIsPoint = 1;
struct ClassBits {
  uint64_t words[4];
};

inline ClassBits class_bits(const PointPlane& current, const PointPlane& previous, int32_t y,
                            int word) {
  return {{current.points[y].shifted_up().word[word], y > 0 ? current.points[y - 1].word[word] : 0,
           previous.points[y].word[word], y > 0 ? previous.points[y - 1].word[word] : 0}};
}

/// The points of a plane in coding order, with their classes and context keys.
struct PlanePoints {
  static constexpr int32_t kMax = kLatticeAcross * kLatticeAcross;
  static constexpr int32_t kSlack = 8;  ///< vectors read and write beyond the last point
  int32_t first[kLatticeAcross + 1];    ///< first point of each row; the last entry: all points
  // Entries beyond the last point are read with it. They are left over from another plane, or zero,
  // and so valid.
  uint8_t x[kMax + kSlack] = {};
  uint8_t point_class[kMax + kSlack] = {};
  uint8_t key[kMax + kSlack];  ///< octave and group: residual_key()

  template <class Ops>
  void set(const PointPlane& current, const PointPlane& previous, const Energies& energies,
           int32_t last_y) {
    int32_t count = 0;
    for (int32_t y = 0; y <= last_y; ++y) {
      first[y] = count;
      const PointMask points = current.points[y];
      if (!points.any()) continue;
      const EnergyRows around = energies.around(y);
      const ClassBits classes = class_bits(current, previous, y, 0);
      count += Ops::list_points(points.word[0], classes.words, around, x + count,
                                point_class + count, key + count);
      if (points.word[1]) {
        const ClassBits last = class_bits(current, previous, y, 1);
        x[count] = kBlockCells;
        point_class[count] = static_cast<uint8_t>(class_at(last.words, 0));
        key[count] = static_cast<uint8_t>(half_octave(around.around(kBlockCells)));
        ++count;
      }
    }
    first[last_y + 1] = count;
    for (int32_t i = 0; i < count; ++i) {
      key[i] = static_cast<uint8_t>(residual_key(key[i], group_of_class(point_class[i])));
    }
  }
};

/// A class predicts a point from 14 neighbours (taps), with weights in units of 1/128, in the order
///
///   0–2  (x − 1, x, x + 1) of (y − 1, z)        9–11  of (y − 1, z − 1)
///   3–5  of (y, z − 1)                          12    (x − 1, y, z)
///   6–8  of (y + 1, z − 1)                      13    (x − 2, y, z)
///
/// The weights of a class sum to 128, so the weight of tap 1 follows from the others; it is not
/// stored.
inline constexpr int kImpliedTap = 1;
inline constexpr int kWeightBits = 7;
inline constexpr int32_t kMaxWeight = 1023;

/// The weights of one class, arranged for vectors. 64 bytes, so that an index becomes an address by
/// a shift.
struct alignas(64) ClassWeights {
  /// Taps 0–11: each group of three is followed by a zero. Exception: if the left neighbour is not
  /// a point, entry 3 is the weight of tap 12, since the value of this neighbour is known before
  /// the points of the row are decoded.
  int16_t rows[16] = {};
  int16_t own[2] = {};  ///< taps 13 and 12, in the order of the row
  int32_t left = 0;     ///< tap 12 if the left neighbour is a point, else zero
  int32_t left2 = 0;    ///< tap 13

  void set(const int32_t* taps, bool left_is_point) {
    for (int i = 0; i < 12; ++i) rows[i / 3 * 4 + i % 3] = static_cast<int16_t>(taps[i]);
    rows[3] = static_cast<int16_t>(left_is_point ? 0 : taps[12]);
    own[0] = static_cast<int16_t>(taps[13]);
    own[1] = static_cast<int16_t>(taps[12]);
    left = left_is_point ? taps[12] : 0;
    left2 = taps[13];
  }
};

struct Predictor {
  ClassWeights classes[kClasses];
  int32_t greatest = 32767;  ///< upper limit of predictions; the lower limit is −32768

  void set(const int32_t (*taps)[kTaps], bool wide) {
    for (uint32_t c = 0; c < kClasses; ++c) classes[c].set(taps[c], (c & kLeftIsPoint) != 0);
    greatest = wide ? 32767 : 255 - 32768;
  }

  /// sum: of the taps that ClassWeights::rows weights; row: the point's own row, from the point on.
  int32_t predict(const ClassWeights& weights, int32_t sum, const int16_t* row) const {
    return prediction(sum + weights.left * row[-1] + weights.left2 * row[-2]);
  }
  /// The prediction from the weighted sum over all taps.
  int32_t prediction(int32_t sum) const {
    const int32_t rounded = (sum + (1 << (kWeightBits - 1))) >> kWeightBits;
    // A rarely taken branch: std::clamp would make the next point wait for two more operations.
    if (__builtin_expect(rounded < -32768 || rounded > greatest, 0)) {
      return std::clamp(rounded, -32768, greatest);
    }
    return rounded;
  }
};

inline TapPointers taps_at(const Neighbours& n, int32_t x) {
  const int32_t i = kRowPad + x - 1;
  return {n.up->value + i, n.back->value + i, n.back_down->value + i, n.back_up->value + i};
}

}  // namespace isosplat
