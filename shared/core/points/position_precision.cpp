#include "shared/core/points/position_precision.h"

#include <algorithm>
#include <cmath>

namespace isosplat {

bool needs_doubles(const VolumeGrid& grid) {
  double farthest = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3d at = grid.world({corner & 1 ? double(grid.voxels.x) : -1.0,
                                 corner & 2 ? double(grid.voxels.y) : -1.0,
                                 corner & 4 ? double(grid.voxels.z) : -1.0});
    farthest = std::max({farthest, std::abs(at.x), std::abs(at.y), std::abs(at.z)});
  }
  const double voxel = std::min({grid.spacing.x, grid.spacing.y, grid.spacing.z});
  return !(std::ldexp(farthest, -24) <= voxel / 2000);
}

}  // namespace isosplat
