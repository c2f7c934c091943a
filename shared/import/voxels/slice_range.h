#pragma once

#include <cstddef>
#include <cstdint>

#include "shared/core/base/status.h"
#include "shared/core/grid/volume_source.h"

namespace isosplat::import {

/// Checks the arguments of VolumeSource::read_slices: `bytes` is the size of `out`. Errors:
/// invalid_argument.
inline Result<void> check_slices(const VolumeHeader& header, int32_t first, int32_t count,
                                 size_t bytes) {
  const Index3 n = header.grid.voxels;
  const size_t slice =
      static_cast<size_t>(n.x) * static_cast<size_t>(n.y) * voxel_bytes(header.type);
  if (first >= 0 && count >= 1 && int64_t{first} + count <= n.z &&
      bytes == slice * static_cast<size_t>(count)) {
    return {};
  }
  return fail(Status::invalid_argument, "expected a range of slices inside the volume");
}

/// The same for VolumeSource::read_rows.
inline Result<void> check_rows(const VolumeHeader& header, const SliceRows& part, size_t bytes) {
  const Index3 n = header.grid.voxels;
  if (part.first_slice >= 0 && part.slices >= 1 && int64_t{part.first_slice} + part.slices <= n.z &&
      part.first_row >= 0 && part.rows >= 1 && int64_t{part.first_row} + part.rows <= n.y &&
      bytes == part.voxels(n.x) * voxel_bytes(header.type)) {
    return {};
  }
  return fail(Status::invalid_argument, "expected rows of slices inside the volume");
}

}  // namespace isosplat::import
