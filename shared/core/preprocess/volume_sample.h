#pragma once

#include <vector>

#include "shared/core/preprocess/block_gather.h"
#include "shared/core/preprocess/layer.h"
#include "shared/core/preprocess/statistics.h"

namespace isosplat {

/// A few slices of the cells of one block.
struct SampleColumn {
  Index3 cells;
  std::vector<CellInterval> intervals;  ///< one per cell, x fastest; min ≥ max: never active
  double bits = 0;                      ///< estimate of the coded bits per voxel of active cells
};

/// A sample of a volume, taken before the build: statistics of some slices, and some columns of
/// cells. Does not depend on the number of threads.
struct VolumeSample {
  VolumeStatistics statistics;
  uint64_t voxels = 0;  ///< how many voxels `statistics` has
  /// Number of columns along each axis. They are distributed evenly over the blocks: in x and y one
  /// column per stride × stride blocks; in z layers_per_block columns per layer of blocks, or one
  /// column per several layers if there are many.
  Index3 columns_across;
  int32_t stride = 1;
  int32_t layers_per_block = 1;
  std::vector<SampleColumn> columns;  ///< x fastest, then y, then z
};

/// Makes a column of the cells of a block, as far as the layer has them. scratch: its memory is
/// reused.
SampleColumn sample_column(const Layer& layer, Index3 block, GatheredBlock& scratch);

}  // namespace isosplat
