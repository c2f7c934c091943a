#pragma once

#include <filesystem>
#include <string_view>

#include "shared/import/volume/import_options.h"
#include "shared/import/volume/opened_volume.h"

namespace isosplat::import {

/// Whether the first bytes of a file are those of Gaussian's cube format, which has no signature:
/// its six lines of numbers.
bool is_cube(std::string_view head);

/// Opens a cube file of Gaussian and other programs of quantum chemistry. Errors: those of
/// open_volume.
Result<OpenVolume> open_cube(const std::filesystem::path& path, const ImportOptions& options);

}  // namespace isosplat::import
