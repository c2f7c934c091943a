#pragma once

#include <span>

#include "shared/core/base/vec3.h"

namespace isosplat {

/// The sides of voxels before signed_distances().
inline constexpr float kInside = -1, kOutside = 1;

/// Replaces the side of each voxel (x fastest; kInside or kOutside) by the distance of its centre
/// from the border between both sides, which consists of faces of voxels: negative inside, in the
/// units of `spacing`. The volume's own border is no border. With one side alone, distances are
/// infinite. Exact up to the rounding of floats, in place, in a time that is linear in the voxels:
/// separable lower envelopes of parabolas (Felzenszwalb and Huttenlocher 2012, "Distance transforms
/// of sampled functions", sections 2 and 3), with parabolas at the faces instead of the centres.
void signed_distances(Index3 size, Vec3d spacing, std::span<float> voxels);

}  // namespace isosplat
