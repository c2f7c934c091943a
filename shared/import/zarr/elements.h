#pragma once

#include <cstddef>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "shared/core/base/status.h"
#include "shared/import/voxels/stored_voxels.h"

namespace isosplat::import::zarr {

/// The elements of an array by the name of their type: "uint16" (version 3), "<u2" (version 2).
/// Errors: unsupported_type.
Result<StoredVoxels> type_of(const std::string& name, const std::filesystem::path& folder);

/// An element with the fill value, in the order of its bytes in files; empty: 0. Values are
/// numbers, "NaN", "Infinity", "-Infinity", or bits such as "0x7fc00000". Errors: malformed_volume.
Result<std::vector<std::byte>> fill_of(const nlohmann::json& fill, const StoredVoxels& stored,
                                       const std::filesystem::path& folder);

}  // namespace isosplat::import::zarr
