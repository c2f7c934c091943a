#pragma once

#include <cstddef>
#include <span>

#include "shared/grid/voxel_type.h"

namespace isosplat {

/// How a file stores its voxels, and what values they stand for: intercept + slope · voxel. Both
/// are kept apart from the voxels all the way to the store, whose codes are the voxels' own
/// integers.
struct StoredVoxels {
  VoxelType type = VoxelType::u8;
  bool big_endian = false;
  double slope = 1;  ///< finite and not 0
  double intercept = 0;
};

/// Swaps bytes where the file's order is not this machine's.
void to_native_order(const StoredVoxels& voxels, std::span<std::byte> bytes);

}  // namespace isosplat
