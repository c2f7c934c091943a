#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace isosplat {

/// The size of every header that npy_header() writes.
constexpr size_t kNpyHeaderBytes = 256;

/// The header of a NumPy array file (format version 1.0, little-endian, C order), which the array's
/// bytes follow. `dtype`: its type in Python, such as "'<f4'". `shape`: a tuple in Python, such as
/// "(100, 3)". Both together have at most 160 characters.
std::string npy_header(std::string_view dtype, std::string_view shape);

}  // namespace isosplat
