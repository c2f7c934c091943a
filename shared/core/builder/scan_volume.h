#pragma once

#include <functional>

#include "shared/core/builder/executor.h"
#include "shared/core/grid/volume_source.h"
#include "shared/core/preprocess/voxel_scan.h"

namespace isosplat {

/// Whether a scan for a build must read all voxels. The quantization of integers of up to 16 bits
/// is usually known after a few slices, unless the caller allows an error.
inline bool scans_all(const VolumeHeader& header, double max_error) {
  return voxel_bytes(header.type) > 2 || max_error > 0;
}

/// Scans the values of a volume, front to back, some MB at a time, in parallel.
/// Unless `scan_all`, stops as soon as the quantization is known (VoxelScan::is_settled). Calls
/// progress(voxels read since the last call). Errors: those of the source.
Result<VoxelScan> scan_volume(VolumeSource& source, Executor& executor, bool scan_all,
                              const std::function<void(uint64_t voxels)>& progress);

/// The same for the slices [first, end) of a volume, of which other processes scan the others.
Result<VoxelScan> scan_slices(VolumeSource& source, Executor& executor, int32_t first, int32_t end,
                              bool scan_all, const std::function<void(uint64_t voxels)>& progress);

}  // namespace isosplat
