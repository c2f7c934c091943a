#pragma once

#include <filesystem>
#include <string_view>

#include "shared/import/volume/import_options.h"
#include "shared/import/volume/opened_volume.h"

namespace isosplat::import {

/// Whether the first bytes of a file, up to 256 of them, are those of DICOM.
bool is_dicom(std::string_view beginning);

/// Whether the file at a path begins so. False if it cannot be read.
bool is_dicom_file(const std::filesystem::path& path);

/// Opens a file with several frames. Errors: those of open_volume.
Result<OpenVolume> open_dicom_file(const std::filesystem::path& path, const ImportOptions& options);

/// Opens a folder with the files of a series. Errors: those of open_volume.
Result<OpenVolume> open_dicom_folder(const std::filesystem::path& path,
                                     const ImportOptions& options);

}  // namespace isosplat::import
