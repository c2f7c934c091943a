#pragma once

#include <vector>

#include "shared/preprocess/statistics.h"

namespace isosplat {

/// How likely an isovalue is below each quantized value, as BandOptions::isovalue_distribution
/// wants it: 65537 entries. `sample`: the quantized values of a part of the volume, of `voxels`
/// voxels.
std::vector<double> guess_isovalues(const VolumeStatistics& sample, uint64_t voxels);

}  // namespace isosplat
