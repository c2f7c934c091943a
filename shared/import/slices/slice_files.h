#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

namespace isosplat::import {

/// Whether a comes before b if runs of digits are compared as numbers: slice_2 before slice_10.
bool natural_order(std::string_view a, std::string_view b);

/// The regular files of a folder whose lower-case extension is one of `extensions` (with the dot;
/// empty: all files), without hidden files, in natural order. Empty if the folder cannot be read.
std::vector<std::filesystem::path> files_of_folder(const std::filesystem::path& folder,
                                                   const std::vector<std::string_view>& extensions);

}  // namespace isosplat::import
