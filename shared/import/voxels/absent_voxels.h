#pragma once

#include <cstddef>
#include <span>

#include "shared/core/grid/voxel_type.h"

// Absent voxels have no value: the file lacks them, or they hold a fill value. They are stored as
// NaN: no surface is drawn around them, and the value range excludes them. Integer volumes with
// absent voxels are read as floating-point numbers; the store keeps these exactly
// (shared/core/preprocess/value_lattice.h).
namespace isosplat::import {

/// The floating-point type that holds all values of `type`: `type` itself if it is one, f32 for
/// integers of 8 and 16 bits, f64 for wider integers (64-bit integers are exact up to 2^53).
VoxelType type_with_absent(VoxelType type);

/// Sets every voxel to NaN. `type`: f32 or f64.
void make_absent(VoxelType type, std::span<std::byte> voxels);

/// Converts voxels to `to`, which is f32 or f64 and can hold their values. Both spans have the same
/// number of voxels and do not overlap.
void convert_voxels(VoxelType from, std::span<const std::byte> in, VoxelType to,
                    std::span<std::byte> out);

}  // namespace isosplat::import
