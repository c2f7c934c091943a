#pragma once

#include <vector>

#include "native/build/value_codes.h"
#include "native/import/volume_source.h"

namespace isosplat {

/// How likely an isovalue is below each code, as SlabOptions::isovalue_distribution wants it: 65537
/// entries. Reads a few slices, front to back. Errors: those of the source.
Result<std::vector<double>> guess_isovalues(VolumeSource& source, const ValueCodes& codes);

}  // namespace isosplat
