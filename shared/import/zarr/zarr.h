#pragma once

#include <filesystem>
#include <vector>

#include "shared/import/volume/import_options.h"
#include "shared/import/volume/opened_volume.h"

namespace isosplat::import {

/// Whether a folder is a group or an array of Zarr.
bool is_zarr(const std::filesystem::path& folder);

/// Opens an image of OME-Zarr (0.1 to 0.5), or an array of Zarr (versions 2 and 3, also in shards).
/// options.dataset: the path of the scale; by default, the finest. Errors: those of open_volume.
Result<OpenVolume> open_zarr(const std::filesystem::path& folder, const ImportOptions& options);

}  // namespace isosplat::import
