#pragma once

#include "shared/core/preprocess/label_tile.h"

namespace isosplat {

/// Fills `values` and `near` of a tile, whose first and size are set: for each voxel the distance
/// from its centre to that of the nearest voxel on the other side of the border, less half a voxel,
/// at most kLabelLimit. Separable minimum of squared distances (Saito and Toriwaki 1994, "New
/// algorithms for Euclidean distance transformation of an n-dimensional digitized picture", section
/// 3), limited to the voxels that matter. Voxels outside of the volume have the label 0.
void compute_distances(const LabelVolume& volume, uint16_t label, LabelTile& tile);

}  // namespace isosplat
