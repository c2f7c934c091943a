#pragma once

#include <optional>
#include <string_view>

#include "shared/core/grid/voxel_type.h"

namespace isosplat::import {

/// Parses a voxel type as the command line and raw file names write it: u8, uint8, uchar, i16,
/// int16, short, f32, float, … Nothing for an unknown name.
std::optional<VoxelType> voxel_type_of(std::string_view name);

}  // namespace isosplat::import
