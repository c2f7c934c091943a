#pragma once

#include <cstdint>
#include <span>

namespace isosplat::import {

/// Continues a CRC-32 of gzip (RFC 1952, 8) with `bytes`. The initial value of `crc` is 0.
uint32_t crc32(uint32_t crc, std::span<const uint8_t> bytes);

/// Continues an Adler-32 of zlib (RFC 1950, 8.2) with `bytes`. The initial value of `adler` is 1.
uint32_t adler32(uint32_t adler, std::span<const uint8_t> bytes);

}  // namespace isosplat::import
