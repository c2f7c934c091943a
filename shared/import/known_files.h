#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace isosplat::import {

/// A file or folder that Isosplat does not read: its kind, and a remedy. Both are parts of a
/// sentence: "expected a volume, found WHAT: REMEDY". Where a command can convert the file, the
/// remedy is this command, and Isosplat reads its output.
struct KnownFile {
  std::string what;
  std::string remedy;
};

/// Identifies a file by its first bytes (up to 4096) and its name, if no reader supports it.
std::optional<KnownFile> known_file(const std::filesystem::path& path, std::string_view beginning);

/// Identifies a folder without slices: a Zarr hierarchy, an empty folder, or one with other
/// folders.
std::optional<KnownFile> known_folder(const std::filesystem::path& path);

}  // namespace isosplat::import
