#pragma once

#include <string>

#include "shared/core/grid/grid.h"
#include "shared/core/grid/voxel_type.h"

namespace isosplat {

/// The description of a volume in its file. A voxel is a number as the file stores it; its value is
/// intercept + slope · voxel.
struct VolumeHeader {
  VolumeGrid grid;
  VoxelType type = VoxelType::u8;
  std::string format;    ///< "NRRD", "NIfTI", "raw", …
  std::string name;      ///< the file's or folder's name without its suffixes
  double slope = 1;      ///< finite and not 0; negative slopes are allowed
  double intercept = 0;  ///< finite
  /// What the world's coordinates refer to, as FORMAT.md names it: "scanner", "mni152", …; empty:
  /// unknown.
  std::string frame_of_reference = {};

  double value(double voxel) const { return intercept + slope * voxel; }
};

}  // namespace isosplat
