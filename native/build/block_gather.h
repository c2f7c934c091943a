#pragma once

#include <vector>

#include "native/build/layer.h"
#include "shared/sampling/cell.h"

namespace isosplat {

/// One block, copied out of its layer: the form in which it is cut and encoded.
struct GatheredBlock {
  Index3 index;
  Index3 cells;
  std::vector<Code> voxels;             ///< (cells.x + 1)(cells.y + 1)(cells.z + 1), x fastest
  std::vector<CellInterval> intervals;  ///< one per cell; {65535, 0} where a corner is missing
};

/// Copies a block's voxels and finds its cells' intervals: at level 0 from their corners, else from
/// the layer. Reuses the memory of `block`.
void gather_block(const Layer& layer, Index3 index, GatheredBlock& block);

}  // namespace isosplat
