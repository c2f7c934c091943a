#pragma once

#include "shared/import/open_volume.h"

namespace isosplat {

/// Makes voxels that stand for "no value" absent (absent_voxels.h). The value is given by the
/// options or by the file's header (volume.fill_value), or it is detected: a single value far
/// outside the range of all others that many voxels of a floating-point volume have. In an integer
/// volume, where such a value may be a label or saturated, it is kept, and a note names it. Every
/// assumption adds a note. Errors: those of the source, which reads up to 64 slices.
Result<OpenVolume> with_missing_values(OpenVolume volume, const ImportOptions& options);

}  // namespace isosplat
