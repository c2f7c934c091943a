#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "shared/import/volume/import_options.h"
#include "shared/import/volume/opened_volume.h"

namespace isosplat::import {

/// Whether the first 4096 bytes of a file have HDF5's signature, perhaps after a user block.
bool is_hdf5(std::string_view beginning);

/// Opens a file of HDF5. Errors: those of open_volume.
Result<OpenVolume> open_hdf5(const std::filesystem::path& path, const ImportOptions& options);

/// The paths of the datasets of an HDF5 file that are volumes, in order. Errors: those of
/// open_volume.
Result<std::vector<std::string>> hdf5_datasets(const std::filesystem::path& path);

}  // namespace isosplat::import
