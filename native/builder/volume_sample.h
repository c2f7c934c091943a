#pragma once

#include <vector>

#include "native/builder/statistics.h"
#include "native/builder/value_codes.h"
#include "native/import/volume_source.h"

namespace isosplat {

/// A few slices of cells of one block.
struct SampleColumn {
  Index3 cells;
  std::vector<CellInterval> intervals;  ///< one per cell, x fastest; min ≥ max: never active
  double bits = 0;  ///< that a voxel of an active cell takes when it is predicted, about
};

/// What is known of a volume before it is built: the codes of some slices, and some columns of
/// cells. The same whatever the number of threads.
struct VolumeSample {
  VolumeStatistics statistics;  ///< of the codes of `voxels` voxels
  uint64_t voxels = 0;
  /// Columns along each axis of a lattice that covers the volume's blocks evenly: a column for each
  /// stride × stride blocks in x and y; in z `layers_per_block` for each layer of blocks, if these
  /// are few, else one for several.
  Index3 columns_across;
  int32_t stride = 1;
  int32_t layers_per_block = 1;
  std::vector<SampleColumn> columns;  ///< x fastest, then y, then z
};

/// Reads 24 slices evenly spread, and up to 60 others, front to back; at most
/// 192 columns. Errors: those of the source.
Result<VolumeSample> sample_volume(VolumeSource& source, const ValueCodes& value_codes,
                                   unsigned threads);

}  // namespace isosplat
