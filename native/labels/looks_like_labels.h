#pragma once

#include "shared/core/grid/volume_source.h"

namespace isosplat {

/// Whether a volume of integers looks like a segmentation, by some of its slices. It does if it has
/// few different values, and if most voxels that do not have the most frequent value are equal to
/// their neighbour. Measured values rarely are, because of noise. False for other types. Errors:
/// those of the source.
Result<bool> looks_like_labels(VolumeSource& source);

}  // namespace isosplat
