#pragma once

#include <filesystem>
#include <string>

#include "native/builder/builder.h"
#include "native/import/open_volume.h"

namespace isosplat::cli {

/// Builds an open volume's store, which keeps the volume's notes. Notes and progress go to stderr.
/// Errors: those of build_store_file, and invalid_argument where the store would be written over
/// one of the volume's files.
Result<BuildReport> build_with_progress(const OpenVolume& volume,
                                        const std::filesystem::path& store, BuildOptions options);

/// What a volume's store is called, without folder and extension: "scan" for "a/scan.nii.gz" and
/// for "a/scan/".
std::string store_stem(const std::filesystem::path& volume);

/// Whether a file begins as a store does.
bool is_store(const std::filesystem::path& path);

}  // namespace isosplat::cli
