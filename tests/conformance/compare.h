#pragma once

#include <string>
#include <vector>

#include "tests/conformance/sample.h"

namespace isosplat::conformance {

/// All voxels of a volume as values, x fastest. Errors: read errors.
Result<std::vector<double>> read_values(VolumeSource& source);

/// Describes a difference between a volume and the truth, in values or world positions; empty if
/// there is none. `may_be_incomplete`: voxels may be NaN, and slices at the ends may be missing.
std::string difference(const VolumeGrid& grid, const std::vector<double>& values,
                       const Truth& truth, bool may_be_incomplete = false);

}  // namespace isosplat::conformance
