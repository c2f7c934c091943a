#pragma once

#include <filesystem>

#include "shared/import/volume/import_options.h"
#include "shared/import/volume/opened_volume.h"

namespace isosplat::import {

/// Opens a file that begins as NRRD. Errors: those of open_volume.
Result<OpenVolume> open_nrrd(const std::filesystem::path& path, const ImportOptions& options);

}  // namespace isosplat::import
