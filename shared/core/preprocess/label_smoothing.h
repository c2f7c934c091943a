#pragma once

#include <span>

#include "shared/core/preprocess/label_tile.h"

namespace isosplat {

/// The greatest of the distances for smooth_distances().
inline constexpr int32_t kMaxSmoothingDistance = 6;

/// Removes the stairs of voxels from the signed distances of a tile: waves along the border of
/// about 2d voxels, for each of the distances d. Every voxel stays on its side of the border.
///
/// For each distance d, and along each axis, f becomes f + w φ(t) / 16, where
/// t = 4 (f(−d) + f(d)) − f(−2d) − f(2d) − 6 f is the negative fourth difference. Without w and φ
/// this is the kernel (−1, 4, 10, 4, −1)/16, which has no second moment: it leaves planes,
/// parabolas and slightly curved surfaces where they are, and removes waves of 2d voxels. Two
/// limits keep it from crossing to another part of the border:
/// - φ(t) is t up to 4 voxels, and decreases to 0 at 8: the kink of a distance in the middle of a
///   thin sheet or vessel gives more than that, and stairs give less.
/// - w decreases from 1 where both |f(±2d)| are up to 2 voxels to 0 where one has the limit of the
///   distances. So the smoothing is along the border, not across it.
void smooth_distances(LabelTile& tile, std::span<const int32_t> distances);

}  // namespace isosplat
