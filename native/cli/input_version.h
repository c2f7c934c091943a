#pragma once

#include <filesystem>
#include <span>
#include <string>

namespace isosplat::cli {

/// Identifies the content of files without reading them, as a part of a key: a line with the path,
/// the size and the time of modification of each.
std::string input_versions(std::span<const std::filesystem::path> files);

}  // namespace isosplat::cli
