#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "shared/core/grid/voxel_type.h"
#include "shared/import/dicom/frames.h"

namespace isosplat::import::dicom {

/// The type and mapping with which the pixels of all frames are read.
struct Values {
  VoxelType type = VoxelType::i16;
  bool has_one_rescaling = true;
  double min_slope = 1, greatest_slope = 1;
  // for the volume header; if not 1 and 0, voxels are the stored pixels
  double slope = 1, intercept = 0;
  std::optional<int> label;
};

/// Values stay integers if slope and intercept are integers, or if they are equal for all frames,
/// in which case they become the volume's slope and intercept. Other values become floating-point
/// numbers, of 64 bits if pixels have more than 16 bits; so do integers if some voxels are absent.
/// With a label, voxels are 0 and 1.
Values find_values(const Collection& collection, std::span<const uint32_t> frames,
                   std::optional<int> label = std::nullopt);

}  // namespace isosplat::import::dicom
