#pragma once

#include <filesystem>
#include <vector>

#include "shared/import/volume/import_options.h"
#include "shared/import/volume/opened_volume.h"

namespace isosplat::import {

/// Opens a file with a page per slice. Errors: those of open_volume.
Result<OpenVolume> open_tiff_file(const std::filesystem::path& path, const ImportOptions& options);

/// Opens a folder with a file per slice. Errors: those of open_volume.
Result<OpenVolume> open_tiff_folder(const std::filesystem::path& path,
                                    const ImportOptions& options);

/// The volumes of a TIFF file, or of the OME-TIFF in a folder. Empty if it needs no choice.
Result<std::vector<VolumeChoice>> tiff_volumes(const std::filesystem::path& path);

}  // namespace isosplat::import
