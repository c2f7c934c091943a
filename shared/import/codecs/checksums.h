#pragma once

#include <cstdint>
#include <span>

namespace isosplat::import {

/// CRC-32 of gzip (RFC 1952, 8) of what `crc` was computed of, followed by `bytes`. It begins with
/// 0.
uint32_t crc32(uint32_t crc, std::span<const uint8_t> bytes);

/// Adler-32 of zlib (RFC 1950, 8.2). It begins with 1.
uint32_t adler32(uint32_t adler, std::span<const uint8_t> bytes);

}  // namespace isosplat::import
