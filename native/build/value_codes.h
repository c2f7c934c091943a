#pragma once

#include <cstdint>
#include <span>

#include "native/import/volume_source.h"

namespace isosplat {

/// The least and greatest finite value among voxels, and how many have none (NaN, infinity,
/// and doubles beyond ±1e300).
struct ValueRange {
  double min = 0, max = 0;  ///< meaningless while is_empty
  bool is_empty = true;     ///< no voxel with a value so far
  uint64_t missing = 0;

  void include(const ValueRange& other);
};

/// The range of voxels as they are in the file (native-endian).
ValueRange range_of(VoxelType type, std::span<const std::byte> voxels);

/// How voxels of a type and range become codes: integers of up to 16 bits exactly, wider ones
/// exactly where their range has at most 65536 values, all else quantised evenly to 65535 codes
/// over the range.
ValueMapping choose_mapping(VoxelType type, const ValueRange& range);

/// Turns voxels of the file into codes, as many as `voxels` holds. `codes` points to bytes where
/// mapping.bits is 8, else to 16-bit numbers; it may be the same memory as `voxels`.
void encode_values(VoxelType type, const ValueMapping& mapping, std::span<const std::byte> voxels,
                   void* codes);

}  // namespace isosplat
