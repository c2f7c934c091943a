#pragma once

#include <vector>

#include "shared/preprocess/statistics.h"

namespace isosplat {

/// How likely an isovalue is below each code, as SlabOptions::isovalue_distribution wants it: 65537
/// entries. `sample`: the codes of a part of the volume, of `voxels` voxels.
std::vector<double> guess_isovalues(const VolumeStatistics& sample, uint64_t voxels);

}  // namespace isosplat
