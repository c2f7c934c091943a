#pragma once

#include "shared/import/volume/import_options.h"
#include "shared/import/volume/opened_volume.h"

namespace isosplat::import {

/// Makes voxels that stand for "no value" absent (absent_voxels.h). The value is given by the
/// options or by the file's header (volume.fill_value), or it is found in a floating-point volume
/// (value_sample.h). Objects, backgrounds and labels of one value are kept, with a note. Every
/// assumption adds a note. Errors: those of the source, which reads up to 64 slices.
Result<OpenVolume> with_missing_values(OpenVolume volume, const ImportOptions& options);

}  // namespace isosplat::import
