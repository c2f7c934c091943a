#pragma once

#include "shared/import/volume/import_options.h"
#include "shared/import/volume/opened_volume.h"

namespace isosplat::import {

/// Makes voxels absent that have the fill value (absent_voxels.h). The fill value comes from the
/// options or from the file's header (volume.fill_value), or is detected in a floating-point volume
/// (value_sample.h). Objects, backgrounds and labels of one value are kept, with a note. Every
/// assumption adds a note. Errors: those of the source, from which up to 64 slices are read.
Result<OpenVolume> with_missing_values(OpenVolume volume, const ImportOptions& options);

}  // namespace isosplat::import
