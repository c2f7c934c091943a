#pragma once

#include <cstddef>
#include <span>

namespace isosplat::import {

/// Decompresses the format of LibLZF, HDF5's filter 32000: a byte below 32 announces as many and
/// one more bytes as they are; others announce a copy of earlier bytes. False if the data are
/// damaged, or do not fill `out` exactly.
bool decompress_lzf(std::span<const std::byte> in, std::span<std::byte> out);

/// Decompresses a block of LZ4: pairs of bytes as they are and of a copy of earlier ones. False as
/// above.
bool decompress_lz4(std::span<const std::byte> in, std::span<std::byte> out);

/// How many bytes one byte of both becomes at most.
constexpr size_t kMostCopyExpansion = 264;

}  // namespace isosplat::import
