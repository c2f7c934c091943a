#pragma once

#include "shared/core/preprocess/block_gather.h"

namespace isosplat {

/// Writes the part of the next coarser level that covers a block. A coarse voxel lies at the even
/// positions of the finer level, and is the [1 2 1]³ average around it, without missing voxels;
/// beyond the faces of the volume, the outermost voxels are repeated. The interval of a coarse cell
/// is the union of the intervals of its up to eight finer cells. Threads may coarsen different
/// blocks at the same time, because each block writes its own part. The layer must hold the slice
/// of voxels before the block, if there is one.
void coarsen_block(const Layer& layer, const GatheredBlock& block, const CoarserLayer& coarser);

}  // namespace isosplat
