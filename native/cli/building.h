#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "native/builder/builder.h"
#include "native/builder/part_build.h"
#include "shared/import/open_volume.h"

namespace isosplat::cli {

/// Builds a store file: build_store_file, or with several processes.
using StoreBuilder = std::function<Result<BuildReport>(
    VolumeSource& source, const std::filesystem::path& target, const BuildOptions& options)>;

/// Builds the store of an open volume. The store keeps the volume's notes. Prints notes and
/// progress on stderr. Errors: those of the builder, and invalid_argument if the store would
/// overwrite one of the volume's files.
Result<BuildReport> build_with_progress(const import::OpenVolume& volume,
                                        const std::filesystem::path& store, BuildOptions options,
                                        const StoreBuilder& builder = build_store_file);

/// As build_with_progress, for a part of a store: build_part_file.
Result<PartReport> build_part_with_progress(const import::OpenVolume& volume,
                                            const std::filesystem::path& path, BuildOptions options,
                                            Part part);

/// States how many voxels --range has changed, if there are any.
void note_clamped(const ClampedVoxels& clamped);

/// The default name of a volume's store, without folder and extension: "scan" for "a/scan.nii.gz"
/// and for "a/scan/".
std::string store_stem(const std::filesystem::path& volume);

/// Whether a file begins with the magic bytes of a store.
bool is_store(const std::filesystem::path& path);

}  // namespace isosplat::cli
