#pragma once

#include <vector>

#include "shared/preprocess/layer.h"
#include "shared/sampling/cell.h"

namespace isosplat {

/// One block, copied out of its layer: the form in which it is cut and encoded.
struct GatheredBlock {
  Index3 index;
  Index3 cells;
  std::vector<QuantizedValue> voxels;       ///< (cells.x + 1)(cells.y + 1)(cells.z + 1), x fastest
  std::vector<CellInterval> intervals;      ///< one per cell; {65535, 0} where a corner is missing
  std::vector<CellInterval> row_intervals;  ///< of each row of cells: what theirs lie in
};

/// Copies a block's voxels and finds its cells' intervals: at level 0 from their corners, else from
/// the layer, but not those of its rows. Reuses the memory of `block`.
void gather_block(const Layer& layer, Index3 index, GatheredBlock& block);

/// Sets block.row_intervals from its intervals.
void find_row_intervals(GatheredBlock& block);

}  // namespace isosplat
