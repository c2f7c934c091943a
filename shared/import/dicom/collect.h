#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "shared/import/dicom/frames.h"
#include "shared/import/volume/import_options.h"

// Collects the frames of a file or of a folder.
namespace isosplat::import::dicom {

/// The frames of a file, two or more. Errors: those of open_dicom_file that do not depend on the
/// options.
Result<Collection> collect_file(const std::filesystem::path& path);

/// The frames of a folder's files, at least one. Adds notes about ignored files. Errors: truncated,
/// malformed_volume and io_error for files that cannot be read, unless gaps are allowed;
/// unsupported_format if there are no frames.
Result<Collection> collect_folder(const std::filesystem::path& path, const ImportOptions& options,
                                  std::vector<std::string>& notes);

/// The names of files without their folders, for messages: "a.txt, b.txt and 3 more".
std::string names_of(const std::vector<std::string>& files);

}  // namespace isosplat::import::dicom
