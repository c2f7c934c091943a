#pragma once

#include <functional>

#include "native/import/volume_source.h"
#include "shared/preprocess/voxel_scan.h"

namespace isosplat {

/// Scans a volume, front to back, some MB at a time, on up to `threads` threads; stops where the
/// scan is settled, unless `whole`. Calls progress(voxels read since the last call). Errors: those
/// of the source.
Result<VoxelScan> scan_volume(VolumeSource& source, unsigned threads, bool whole,
                              const std::function<void(uint64_t voxels)>& progress);

}  // namespace isosplat
