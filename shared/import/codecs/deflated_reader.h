#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "shared/import/bytes/byte_reader.h"

namespace isosplat::import {

/// The container format of deflated data.
enum class Deflate : uint8_t { gzip_or_zlib, raw };

/// Decompresses gzip or zlib data, or deflated data without a container, from byte `start` of a
/// file; several gzip members may follow each other. Reading forwards is fast. To read earlier
/// bytes again, the reader starts at the nearest access point (codecs/access_points.h); in data of
/// up to 256 MiB, it then skips at most 1 MiB. Every byte is checked against the container's
/// checksum when it is decompressed for the first time. Errors: io_error.
Result<std::unique_ptr<ByteReader>> open_deflated(const std::filesystem::path& path,
                                                  uint64_t start = 0,
                                                  Deflate kind = Deflate::gzip_or_zlib);

}  // namespace isosplat::import
