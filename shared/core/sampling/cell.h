#pragma once

#include <algorithm>
#include <array>

#include "shared/core/grid/grid.h"

namespace isosplat {

/// The quantized values of a cell's eight voxels. Corner i lies at (i & 1, i >> 1 & 1, i >> 2 & 1).
using CellCorners = std::array<QuantizedValue, 8>;

/// The range of the quantized values in a cell.
struct CellInterval {
  QuantizedValue min = 0;
  QuantizedValue max = 0;

  friend constexpr bool operator==(const CellInterval&, const CellInterval&) = default;
};

/// The interval of a cell of level 0: the range of its corners. (At coarser levels, the interval is
/// the union of the intervals of the finer cells, so that thin features do not vanish.)
inline CellInterval corner_interval(const CellCorners& corners) {
  // Compilers make vector instructions of this loop, but not of std::minmax_element.
  CellInterval range{corners[0], corners[0]};
  for (const QuantizedValue corner : corners) {
    range.min = std::min(range.min, corner);
    range.max = std::max(range.max, corner);
  }
  return range;
}

/// Whether the isosurface crosses the cell: min ≤ isovalue < max. The half-open interval gives
/// voxels that equal the isovalue to exactly one side.
inline bool is_active(CellInterval interval, float quantized_isovalue) {
  return static_cast<float>(interval.min) <= quantized_isovalue &&
         quantized_isovalue < static_cast<float>(interval.max);
}

/// Whether the cell is active for some quantized isovalue in [low, high].
inline bool is_active_within(CellInterval interval, float low, float high) {
  return static_cast<float>(interval.min) <= high && low < static_cast<float>(interval.max);
}

}  // namespace isosplat
