#pragma once

#include <filesystem>
#include <string_view>

#include "shared/import/volume/import_options.h"
#include "shared/import/volume/opened_volume.h"

namespace isosplat::import {

/// Whether the first bytes of a file are those of XCrySDen's format.
bool is_xsf(std::string_view head);

/// Opens a three-dimensional datagrid of XCrySDen. Errors: those of open_volume.
Result<OpenVolume> open_xsf(const std::filesystem::path& path, const ImportOptions& options);

}  // namespace isosplat::import
