#pragma once

#include <vector>

#include "tests/native/test_volume.h"

namespace isosplat {

/// The angle between two directions, in degrees.
double angle(Vec3d a, Vec3d b);

/// The gradient by central differences at the voxels (one-sided at the ends of the volume),
/// interpolated trilinearly. `p`: a position in voxels. The gradient is in world coordinates.
Vec3d reference_gradient(const TestVolume& volume, Vec3d p);

/// The value below which this share of the values lies; 0 without values. Reorders the values.
double percentile(std::vector<double>& values, double share);

}  // namespace isosplat
