#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "shared/base/status.h"

namespace isosplat {

/// The header of a NumPy array.
struct NpyHeader {
  std::string type;            ///< "descr": byte order, kind and bytes of a voxel, such as "<f4"
  bool fortran_order = false;  ///< the first axis is the fastest; otherwise the last one
  std::vector<int64_t> shape;  ///< by the array's axes; from 0
};

/// Parses the dictionary of a header: a Python literal with exactly the keys "descr",
/// "fortran_order" and "shape", as NumPy writes it. Nothing else is evaluated. Errors:
/// malformed_volume; unsupported_type if a voxel has several fields.
Result<NpyHeader> parse_npy_dictionary(const std::filesystem::path& path, std::string_view text);

/// The index that takes one volume of an array with more than three axes of several elements, in
/// Python: "0, 0" of the shape (2, 3, 6, 7, 8), "..., 0" of (6, 7, 8, 3), "0, ..., 0" of
/// (5, 6, 7, 8, 3).
std::string numpy_index(const std::vector<int64_t>& shape);

/// The error of a header that is not one of NumPy.
tl::unexpected<Error> malformed_npy(const std::filesystem::path& path, const std::string& what);

}  // namespace isosplat
