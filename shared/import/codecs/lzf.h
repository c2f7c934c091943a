#pragma once

#include <cstddef>
#include <span>

namespace isosplat::import {

/// Decompresses the format of LibLZF, HDF5's filter 32000. A byte b below 32 precedes b + 1 literal
/// bytes; other bytes begin a copy of earlier output. Returns false if the data are damaged, or do
/// not fill `out` exactly.
bool decompress_lzf(std::span<const std::byte> in, std::span<std::byte> out);

/// Decompresses a block of LZ4: pairs of literal bytes and a copy of earlier output. Returns false
/// as above.
bool decompress_lz4(std::span<const std::byte> in, std::span<std::byte> out);

/// The maximum number of bytes that one byte of both formats expands to.
constexpr size_t kMostCopyExpansion = 264;

}  // namespace isosplat::import
