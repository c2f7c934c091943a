#pragma once

#include <filesystem>
#include <string>

#include "native/build/builder.h"
#include "native/import/open_volume.h"

namespace isosplat::cli {

/// Opens a volume and builds its store, which keeps the volume's notes. Notes and progress go to
/// stderr unless `quiet`. Errors: those of open_volume and build_store_file.
Result<BuildReport> build_with_progress(const std::filesystem::path& volume,
                                        ImportOptions import_options,
                                        const std::filesystem::path& store, BuildOptions options,
                                        bool quiet = false);

/// What a volume's store is called, without folder and extension: "scan" for "a/scan.nii.gz" and
/// for "a/scan/".
std::string store_stem(const std::filesystem::path& volume);

/// Whether a file begins as a store does.
bool is_store(const std::filesystem::path& path);

}  // namespace isosplat::cli
