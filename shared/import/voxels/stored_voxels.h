#pragma once

#include <cstddef>
#include <span>

#include "shared/core/grid/voxel_type.h"

namespace isosplat::import {

/// The type of the voxels in a file, and their mapping to values: intercept + slope · voxel. The
/// mapping is not applied to the voxels but stored with them, so that the store's quantized values
/// are the file's integers.
struct StoredVoxels {
  VoxelType type = VoxelType::u8;
  bool big_endian = false;
  double slope = 1;  ///< finite and not 0
  double intercept = 0;
  bool is_half = false;  ///< the file has 16-bit floating-point numbers; the type is f32
};

/// Bytes of one voxel in the file.
size_t stored_bytes(const StoredVoxels& voxels);

/// Converts from the file's byte order to native byte order.
void to_native_order(const StoredVoxels& voxels, std::span<std::byte> bytes);

/// The number that the bytes of one voxel in the file encode, without slope and intercept.
double stored_number(const StoredVoxels& voxels, std::span<const std::byte> bytes);

/// Converts 16-bit floating-point numbers (IEEE 754 binary16) in native byte order to f32, exactly.
/// `out` has twice the bytes of `halves`; they do not overlap.
void widen_halves(std::span<const std::byte> halves, std::span<std::byte> out);

}  // namespace isosplat::import
