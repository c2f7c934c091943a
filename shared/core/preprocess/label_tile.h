#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "shared/core/preprocess/label_volume.h"

namespace isosplat {

/// The units of a LabelTile's values.
inline constexpr int16_t kLabelVoxel = 256;              ///< a distance of one voxel
inline constexpr int16_t kLabelLimit = 6 * kLabelVoxel;  ///< the greatest distance
inline constexpr int16_t kLabelLeast = 16;               ///< the least one: a step of LabelField

/// The signed distances of a box of voxels from the border of one label: at least kLabelLeast in
/// the label, at most −kLabelLeast elsewhere. x fastest.
struct LabelTile {
  /// The voxels of a row that may be nearer to the border than kLabelLimit.
  struct Range {
    int32_t begin = 0, end = 0;
  };

  Index3 first, size;
  std::vector<int16_t> values;
  std::vector<int16_t> other;  ///< scratch, as many
  std::vector<Range> near;     ///< of each row, by y and then z

  size_t row_number(int32_t y, int32_t z) const {
    return static_cast<size_t>(z) * static_cast<size_t>(size.y) + static_cast<size_t>(y);
  }
  size_t row_begin(int32_t y, int32_t z) const {
    return row_number(y, z) * static_cast<size_t>(size.x);
  }
  size_t voxels() const { return row_begin(0, size.z); }
};

/// A value that stays on the side of the border on which it was, within the limits of a tile.
constexpr int16_t on_side_of(int16_t before, int16_t value) {
  const int16_t low = before > 0 ? kLabelLeast : static_cast<int16_t>(-kLabelLimit);
  const int16_t high = before > 0 ? kLabelLimit : static_cast<int16_t>(-kLabelLeast);
  const int16_t raised = value < low ? low : value;
  return raised > high ? high : raised;
}

}  // namespace isosplat
