#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "shared/core/base/status.h"
#include "shared/import/volume/allowances.h"

namespace isosplat::import {

/// The files of a stack, one slice each, in the order of the numbers in their names.
struct SliceOrder {
  std::vector<std::filesystem::path> slices;  ///< an empty path is a missing slice
  std::vector<std::string> notes;
};

/// Orders files by their names, for formats that do not store slice positions. Numbers may have a
/// sign ("z-5", "z5") and decimals ("z0.5"). A hyphen before every number is a separator, not a
/// sign.
///
/// Errors: malformed_volume if the names are of several kinds, if two numbers vary independently
/// (times and slices), if the order depends on whether the numbers are decimals, and if numbers are
/// missing, unless gaps are allowed: then missing slices have empty paths.
Result<SliceOrder> order_slices(const std::filesystem::path& folder,
                                std::vector<std::filesystem::path> files, Allowances allowed);

}  // namespace isosplat::import
