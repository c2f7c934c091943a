#pragma once

#include "shared/preprocess/block_gather.h"

namespace isosplat {

/// Writes the part of the next coarser level that lies over a block: the voxels at even places,
/// each the [1 2 1]³ average of its neighbourhood (missing ones left out; at the volume's faces the
/// outermost voxel is repeated), and for each coarse cell the union of the intervals of the up to
/// eight cells below. Blocks write disjoint parts, so they may be worked on at the same time.
/// Requires the layer to hold one slice of voxels before the block's first, where there is one.
void coarsen_block(const Layer& layer, const GatheredBlock& block, const CoarserLayer& coarser);

}  // namespace isosplat
