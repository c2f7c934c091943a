#pragma once

#include <filesystem>

#include "shared/import/volume/import_options.h"
#include "shared/import/volume/opened_volume.h"

namespace isosplat::import {

/// Opens an array of NumPy. Errors: those of open_volume.
Result<OpenVolume> open_npy(const std::filesystem::path& path, const ImportOptions& options);

}  // namespace isosplat::import
