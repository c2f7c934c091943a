#pragma once

#include <filesystem>
#include <string>

namespace isosplat {

/// The hash of a volume's path in a store's metadata (FORMAT.md, META): XXH3-64 of the path
/// relative to the store's folder, with links resolved, as 16 hexadecimal digits.
std::string source_path_hash(const std::filesystem::path& volume,
                             const std::filesystem::path& store);

/// The last component of a path: "scan" for "a/scan" and "a/scan/".
std::string source_file_name(const std::filesystem::path& volume);

}  // namespace isosplat
