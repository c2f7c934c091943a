#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

// Parts of the commands that errors recommend.
namespace isosplat::import {

/// A word of a command line, quoted if the shell would change it.
std::string shell_word(const std::filesystem::path& path);

/// The Python index that selects one volume of an array with more than three axes of several
/// elements: "0, 0" for the shape (2, 3, 6, 7, 8), "..., 0" for (6, 7, 8, 3), "0, ..., 0" for (5,
/// 6, 7, 8, 3).
std::string numpy_index(const std::vector<int64_t>& shape);

}  // namespace isosplat::import
