#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "native/import/allowances.h"
#include "shared/base/status.h"

namespace isosplat {

/// The files of a stack, a slice each, in the order of the numbers in their names.
struct SliceOrder {
  std::vector<std::filesystem::path> slices;  ///< an empty path is a slice that is missing
  std::vector<std::string> notes;
};

/// Orders files by their names alone, for formats that do not say where a slice lies. Numbers may
/// have a sign ("z-5", "z5") and decimals ("z0.5"). A hyphen before every number is no sign.
///
/// Errors: malformed_volume where the names are of several kinds, where they count along two
/// numbers at once (times and slices), where the order depends on whether numbers have decimals,
/// and where numbers are missing, unless gaps are allowed: then missing slices are left open.
Result<SliceOrder> order_slices(const std::filesystem::path& folder,
                                std::vector<std::filesystem::path> files, Allowances allowed);

}  // namespace isosplat
