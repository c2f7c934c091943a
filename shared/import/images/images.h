#pragma once

#include <cstdint>
#include <filesystem>

#include "shared/import/volume/import_options.h"
#include "shared/import/volume/opened_volume.h"

namespace isosplat::import {

/// Opens a folder with a picture per slice: PNG, JPEG or JPEG 2000. Errors: those of open_volume.
Result<OpenVolume> open_image_folder(const std::filesystem::path& path,
                                     const ImportOptions& options);

/// The bytes of a folder's pictures of one format; 0 if it has fewer than two.
uint64_t image_bytes_of_folder(const std::filesystem::path& folder);

}  // namespace isosplat::import
