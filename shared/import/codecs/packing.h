#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string_view>

#include "shared/core/base/status.h"

namespace isosplat::import {

/// The compression of a file as a whole, by its first bytes.
enum class Packing : uint8_t { none, gzip, bzip2, xz, zstd };

Packing packing_of(std::string_view beginning);

/// "gzip", "bzip2", "xz", "zstd": also the name of the program that decompresses with the option
/// -d.
std::string_view name_of(Packing packing);

/// A file's name without the suffix of compressed files: "head.nii.bz2" → "head.nii".
std::filesystem::path unpacked_name(const std::filesystem::path& path);

/// Decompresses a file from its beginning to its end. Several compressed streams may follow each
/// other. Not thread-safe.
class UnpackStream {
 public:
  virtual ~UnpackStream() = default;

  /// Decompresses out.size() bytes, or fewer at the end. Errors: io_error, truncated,
  /// malformed_volume for damaged data, out_of_memory if the data need more than 256 MiB.
  virtual Result<size_t> read_some(std::span<std::byte> out) = 0;
};

/// With zlib, libbz2, liblzma and libzstd: native only. Errors: io_error, out_of_memory.
Result<std::unique_ptr<UnpackStream>> open_unpack_stream(const std::filesystem::path& path,
                                                         Packing packing);

}  // namespace isosplat::import
