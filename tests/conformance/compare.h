#pragma once

#include <string>
#include <vector>

#include "tests/conformance/sample.h"

namespace isosplat::conformance {

/// All voxels of a volume as values, x fastest. Errors: those of reading.
Result<std::vector<double>> read_values(VolumeSource& source);

/// What is different from the truth in where voxels lie in the world and what they are; empty:
/// nothing. `may_lack`: voxels may have no value (not a number), and slices at the ends may be
/// missing.
std::string difference(const VolumeGrid& grid, const std::vector<double>& values,
                       const Truth& truth, bool may_lack = false);

}  // namespace isosplat::conformance
