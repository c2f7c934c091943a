#pragma once

#include <filesystem>

#include "shared/import/codecs/file_head.h"
#include "shared/import/volume/import_options.h"
#include "shared/import/volume/opened_volume.h"

namespace isosplat::import {

/// Whether a raw file's name contains its dims and type.
bool raw_name_is_complete(const std::filesystem::path& path);

/// Opens raw voxels. Errors: those of open_volume.
Result<OpenVolume> open_raw(const FileHead& head, const ImportOptions& options);

}  // namespace isosplat::import
