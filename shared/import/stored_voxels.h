#pragma once

#include <cstddef>
#include <span>

#include "shared/grid/voxel_type.h"

namespace isosplat {

/// How a file stores its voxels, and how they map to values: intercept + slope · voxel. The mapping
/// is not applied to the voxels: it is passed on to the store, whose quantized values are the
/// file's integers.
struct StoredVoxels {
  VoxelType type = VoxelType::u8;
  bool big_endian = false;
  double slope = 1;  ///< finite and not 0
  double intercept = 0;
};

/// Converts from the file's byte order to native byte order.
void to_native_order(const StoredVoxels& voxels, std::span<std::byte> bytes);

}  // namespace isosplat
