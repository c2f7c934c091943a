#pragma once

#include <cstddef>
#include <span>

#include "shared/grid/voxel_type.h"

// Voxels without a value: those that a file lacks, and those that hold a fill value. They are not a
// number (NaN), so that no surface is drawn around them and they take no part of the range of
// values. Volumes of integers that have such voxels are read as floating-point numbers; the store
// keeps these as exactly as integers (shared/preprocess/value_lattice.h).
namespace isosplat {

/// The floating-point type that holds the values of a type: itself, f32 for integers of 8 and 16
/// bits, f64 for wider ones (of 64 bits, exact up to 2^53).
VoxelType type_with_absent(VoxelType type);

/// Makes every voxel absent. `type`: f32 or f64.
void make_absent(VoxelType type, std::span<std::byte> voxels);

/// Converts voxels of one type to another that can hold them. The spans have equally many voxels,
/// and do not overlap.
void convert_voxels(VoxelType from, std::span<const std::byte> in, VoxelType to,
                    std::span<std::byte> out);

}  // namespace isosplat
