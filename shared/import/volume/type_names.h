#pragma once

#include <optional>
#include <string_view>

#include "shared/core/grid/voxel_type.h"

namespace isosplat::import {

/// Parses the name of a voxel type on the command line or in the name of a raw file: u8, uint8,
/// uchar, i16, int16, short, f32, float, … Nothing for an unknown name.
std::optional<VoxelType> voxel_type_of(std::string_view name);

}  // namespace isosplat::import
