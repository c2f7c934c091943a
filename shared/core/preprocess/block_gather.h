#pragma once

#include <vector>

#include "shared/core/preprocess/layer.h"
#include "shared/core/sampling/cell.h"

namespace isosplat {

/// One block, copied from its layer. Band planning and encoding read this form.
struct GatheredBlock {
  Index3 index;
  Index3 cells;
  std::vector<QuantizedValue> voxels;       ///< (cells.x + 1)(cells.y + 1)(cells.z + 1), x fastest
  std::vector<CellInterval> intervals;      ///< one per cell; {65535, 0} where a corner is missing
  std::vector<CellInterval> row_intervals;  ///< for each row of cells, the union of their intervals
};

/// Copies a block's voxels, and sets its cells' intervals: computed from the corners at level 0,
/// copied from the layer at coarser levels. Does not set row_intervals. Reuses the memory of
/// `block`.
void gather_block(const Layer& layer, Index3 index, GatheredBlock& block);

/// Sets block.row_intervals from block.intervals.
void find_row_intervals(GatheredBlock& block);

}  // namespace isosplat
