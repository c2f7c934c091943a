#pragma once

#include <filesystem>
#include <string_view>

#include "shared/import/volume/import_options.h"
#include "shared/import/volume/opened_volume.h"

namespace isosplat::import {

/// Whether the first bytes of a file are those of OpenDX's native format.
bool is_opendx(std::string_view head);

/// Opens a regular grid of OpenDX, as APBS writes it. Errors: those of open_volume.
Result<OpenVolume> open_opendx(const std::filesystem::path& path, const ImportOptions& options);

}  // namespace isosplat::import
