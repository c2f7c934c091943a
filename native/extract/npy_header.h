#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace isosplat {

/// The size of a header with a short type.
constexpr size_t kNpyHeaderBytes = 256;

/// The header of a NumPy array file (format version 1.0, little-endian, C order), which the array's
/// bytes follow. `dtype`: its type in Python, such as "'<f4'". `shape`: a tuple in Python, such as
/// "(100, 3)". Both together have at most `bytes` − 96 characters. bytes: the size of the header, a
/// multiple of 64.
std::string npy_header(std::string_view dtype, std::string_view shape,
                       size_t bytes = kNpyHeaderBytes);

}  // namespace isosplat
