#pragma once

#include <filesystem>

#include "shared/import/volume/import_options.h"
#include "shared/import/volume/opened_volume.h"

namespace isosplat::import {

/// Opens structured points of a legacy VTK file. Errors: those of open_volume.
Result<OpenVolume> open_vtk_legacy(const std::filesystem::path& path, const ImportOptions& options);

}  // namespace isosplat::import
