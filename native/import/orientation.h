#pragma once

#include <string>
#include <vector>

#include "shared/base/status.h"
#include "shared/grid/grid.h"

namespace isosplat {

/// Where voxels are, as a file's header says it: any matrix, any handedness.
struct HeaderGeometry {
  Vec3d spacing{1, 1, 1};
  Vec3d origin{0, 0, 0};            ///< the centre of voxel (0, 0, 0)
  Matrix3d direction = kIdentity3;  ///< its columns are the axes, of any length
};

/// A grid as VolumeGrid wants it, and what had to be done for it.
struct Orientation {
  VolumeGrid grid;

  /// The rows of each slice must be read in reverse order. That is how a left-handed header becomes
  /// a right-handed grid with every voxel still at its place in the world: nothing is mirrored.
  bool reverse_rows = false;

  std::vector<std::string> notes;  ///< for people, where the header was not taken word by word
};

/// Makes a grid of a header's geometry: axes of unit length, right-handed. Axes that are not
/// perpendicular stay so: every voxel keeps its place. A spacing that is not a positive number is
/// replaced by 1, and axes that (nearly) lie in a plane (is_basis) by x, y and z. Errors: no_cells,
/// volume_too_large, and malformed_volume where an axis has no voxel.
Result<Orientation> orient(Vec3<int64_t> voxels, HeaderGeometry geometry);

}  // namespace isosplat
