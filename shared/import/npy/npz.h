#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "shared/import/volume/import_options.h"
#include "shared/import/volume/opened_volume.h"

namespace isosplat::import {

/// Whether a file begins as an archive of NumPy arrays: a ZIP whose first file is an array.
bool is_npz(std::string_view beginning);

/// The names of the arrays in an archive that are volumes. Errors: those of open_volume.
Result<std::vector<std::string>> npz_datasets(const std::filesystem::path& path);

/// Opens one of the arrays of an archive (.npz); options.dataset chooses it by its name. Errors:
/// those of open_volume.
Result<OpenVolume> open_npz(const std::filesystem::path& path, const ImportOptions& options);

}  // namespace isosplat::import
