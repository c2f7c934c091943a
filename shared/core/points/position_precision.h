#pragma once

#include "shared/core/grid/grid.h"

namespace isosplat {

/// Whether single precision would move a point of the volume by more than 1/2000 of a voxel.
bool needs_doubles(const VolumeGrid& grid);

}  // namespace isosplat
