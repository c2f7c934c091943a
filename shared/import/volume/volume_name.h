#pragma once

#include <filesystem>
#include <string>

namespace isosplat::import {

/// A file name without folder and suffixes: "a/b.nii.gz" → "b".
std::string volume_name(const std::filesystem::path& path);

}  // namespace isosplat::import
