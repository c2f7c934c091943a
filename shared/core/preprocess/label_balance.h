#pragma once

#include "shared/core/preprocess/label_tile.h"

namespace isosplat {

/// Shifts the border of a tile's label so that the trilinear surface encloses the volume of the
/// label's voxels, in each neighbourhood of about 36 voxels. Smoothing shrinks thin parts, and the
/// trilinear surface of an exact distance is smaller than the body if that is convex. Every voxel
/// stays on its side of the border.
///
/// In each cell that the border crosses, the fraction of 4³ points that are inside is compared with
/// the fraction of its eight voxels that have the label. The differences and the areas of the
/// border are summed in bricks of 4³ cells. The difference of each brick is distributed over the
/// border in nine bricks along each axis. This is the shift at the middle of a brick, at most 0.3
/// voxels; between the middles, it is interpolated.
/// This is done `rounds` times, because in thin parts the limits of the voxels' values allow only a
/// part of the shift.
void balance_volume(LabelTile& tile, int32_t rounds);

}  // namespace isosplat
