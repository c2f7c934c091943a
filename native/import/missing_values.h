#pragma once

#include "native/import/open_volume.h"

namespace isosplat {

/// Makes voxels that stand for "no value" absent (absent_voxels.h). Which value that is, options
/// say, or the file's header (volume.fill_value), or it is found: a single value far outside the
/// range of all others that fills a share of a floating-point volume. Such a value in a volume of
/// integers, where it may as well be a label or saturated, is kept and noted. Whatever was assumed
/// is noted. Errors: those of the source, of which up to 64 slices are read.
Result<OpenVolume> with_missing_values(OpenVolume volume, const ImportOptions& options);

}  // namespace isosplat
