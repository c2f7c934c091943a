#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace isosplat::import {

/// A file or folder that Isosplat does not read: what it is, and what to do. Both are parts of a
/// sentence: "expected a volume, found WHAT: REMEDY". A remedy is one command where there is one,
/// and what the command writes can be read.
struct KnownFile {
  std::string what;
  std::string remedy;
};

/// Tells what a file is by its first bytes (up to 4096) and its name, if no reader takes it.
std::optional<KnownFile> known_file(const std::filesystem::path& path, std::string_view beginning);

/// Tells what a folder is without slices of its own: a Zarr hierarchy, an empty folder, or one with
/// other folders.
std::optional<KnownFile> known_folder(const std::filesystem::path& path);

}  // namespace isosplat::import
