#pragma once

#include <vector>

#include "shared/core/preprocess/statistics.h"

namespace isosplat {

/// Suggests up to `most` quantized isovalues, best first: those at which the surface is the
/// boundary of something. Its cells span many values, there are many of them, their gradients agree
/// with those of nearby cells, and there are voxels with values in between. (The last two tell it
/// from noise, and from the border of a padding or a mask.) None if all values are equal.
///
/// Mean gradients at an isovalue, as a measure of boundaries: Pekar, Wiemker, Hempel, "Fast
/// detection of meaningful isosurfaces for volume data visualization", IEEE Visualization 2001.
std::vector<double> suggest_isovalues(const VolumeStatistics& statistics, size_t most);

}  // namespace isosplat
