#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "shared/core/base/status.h"

namespace isosplat::import {

/// The header of a NumPy array.
struct NpyHeader {
  std::string type;            ///< "descr": byte order, kind and bytes of a voxel, such as "<f4"
  bool fortran_order = false;  ///< the first axis is the fastest; otherwise the last one
  std::vector<int64_t> shape;  ///< by the array's axes; from 0
};

/// Parses the dictionary of a header: a Python literal with exactly the keys "descr",
/// "fortran_order" and "shape", as NumPy writes it. Other expressions are not evaluated. Errors:
/// malformed_volume; unsupported_type if a voxel has several fields.
Result<NpyHeader> parse_npy_dictionary(const std::filesystem::path& path, std::string_view text);

/// The error for a header that NumPy does not write.
tl::unexpected<Error> malformed_npy(const std::filesystem::path& path, const std::string& what);

}  // namespace isosplat::import
