#pragma once

#include "shared/import/codecs/file_head.h"
#include "shared/import/volume/import_options.h"
#include "shared/import/volume/opened_volume.h"

namespace isosplat::import {

/// Opens a NIfTI volume: a single file, or either file of a pair. Errors: those of open_volume.
Result<OpenVolume> open_nifti(const FileHead& head, const ImportOptions& options);

}  // namespace isosplat::import
