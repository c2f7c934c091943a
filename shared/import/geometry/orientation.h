#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "shared/core/base/status.h"
#include "shared/core/grid/grid.h"

namespace isosplat::import {

/// Positions of voxels as a file's header gives them: any matrix, any handedness.
struct HeaderGeometry {
  Vec3d spacing{1, 1, 1};
  Vec3d origin{0, 0, 0};                     ///< the centre of voxel (0, 0, 0)
  Matrix3d direction = kIdentity3;           ///< columns are the axes, of any length
  std::string_view frame_of_reference = {};  ///< for VolumeHeader; a literal
};

/// A valid VolumeGrid, and the order in which its voxels must be read.
struct Orientation {
  VolumeGrid grid;

  /// Whether the rows of each slice must be read in reverse order. This turns a left-handed header
  /// into a right-handed grid; every voxel keeps its position in the world, so nothing is mirrored.
  bool reverse_rows = false;

  std::vector<std::string> notes;  ///< about changes to the header's geometry
};

/// Makes a right-handed grid with axes of unit length from a header's geometry. Axes that are not
/// perpendicular stay so; every voxel keeps its position. A spacing that is not a positive number
/// is replaced by 1. If the axes lie (nearly) in a plane (is_basis), they are replaced by x, y and
/// z. Errors: no_cells, volume_too_large, and malformed_volume if an axis has no voxel.
Result<Orientation> orient(Vec3<int64_t> voxels, HeaderGeometry geometry);

}  // namespace isosplat::import
