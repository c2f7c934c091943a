#pragma once

#include <filesystem>
#include <string>

namespace isosplat::cli {

/// Identifies the content of a file without reading it: its size and time of modification.
std::string input_version(const std::filesystem::path& file);

}  // namespace isosplat::cli
