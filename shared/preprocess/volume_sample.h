#pragma once

#include <vector>

#include "shared/preprocess/block_gather.h"
#include "shared/preprocess/layer.h"
#include "shared/preprocess/statistics.h"

namespace isosplat {

/// A few slices of cells of one block.
struct SampleColumn {
  Index3 cells;
  std::vector<CellInterval> intervals;  ///< one per cell, x fastest; min ≥ max: never active
  double bits = 0;  ///< that a voxel of an active cell takes when it is predicted, about
};

/// What is known of a volume before it is built: the quantized values of some slices, and some
/// columns of cells. The same whatever the number of threads.
struct VolumeSample {
  VolumeStatistics statistics;  ///< of the quantized values of `voxels` voxels
  uint64_t voxels = 0;
  /// Columns along each axis of a lattice that covers the volume's blocks evenly: a column for each
  /// stride × stride blocks in x and y; in z `layers_per_block` for each layer of blocks, if these
  /// are few, else one for several.
  Index3 columns_across;
  int32_t stride = 1;
  int32_t layers_per_block = 1;
  std::vector<SampleColumn> columns;  ///< x fastest, then y, then z
};

/// A column of all cells of a block of `layer`, which has some slices of the volume. `scratch`:
/// reused.
SampleColumn sample_column(const Layer& layer, Index3 block, GatheredBlock& scratch);

}  // namespace isosplat
