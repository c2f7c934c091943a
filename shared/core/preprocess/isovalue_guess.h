#pragma once

#include <vector>

#include "shared/core/preprocess/statistics.h"

namespace isosplat {

/// Guesses which isovalues users will choose: the probability that an isovalue is below each
/// quantized value, in the form of BandOptions::isovalue_distribution (65537 entries). sample:
/// statistics of `voxels` voxels of the volume.
std::vector<double> guess_isovalues(const VolumeStatistics& sample, uint64_t voxels);

}  // namespace isosplat
