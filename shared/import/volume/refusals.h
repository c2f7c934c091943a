#pragma once

#include <filesystem>
#include <string_view>

#include "shared/core/base/status.h"

namespace isosplat::import {

/// The error for a volume whose voxels are vectors or colours.
tl::unexpected<Error> not_scalar(const std::filesystem::path& path, int components);

/// The error for voxels of an unsupported type.
tl::unexpected<Error> unknown_type(const std::filesystem::path& path, std::string_view type);

}  // namespace isosplat::import
