#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <vector>

#include "shared/base/status.h"

namespace isosplat {

/// Bytes that can be read at any offset: a file, or what a compressed file expands to. One thread
/// at a time.
class ByteReader {
 public:
  virtual ~ByteReader() = default;

  /// Reads out.size() bytes from `offset`. Errors: truncated where the bytes end before, io_error,
  /// malformed_volume where compressed data is damaged.
  virtual Result<void> read(uint64_t offset, std::span<std::byte> out) = 0;

  /// No more bytes than this can come: exact for plain files, an upper bound for compressed ones
  /// (deflate expands at most 1032 times).
  virtual uint64_t size_limit() const = 0;

  /// How many bytes follow `offset`, counted up to `most`. What is compressed is expanded for it,
  /// and where it ends its checksum is verified. Errors: those of read.
  virtual Result<uint64_t> count_after(uint64_t offset, uint64_t most) = 0;

  /// How many bytes can be read before an error or the end. Expands all that is compressed.
  virtual uint64_t available_bytes() = 0;

  /// The files that the bytes come from.
  virtual std::vector<std::filesystem::path> files() const = 0;
};

/// A file as it is. Errors: io_error.
Result<std::unique_ptr<ByteReader>> open_plain(const std::filesystem::path& path);

/// What wraps deflated data.
enum class Deflate : uint8_t { gzip_or_zlib, raw };

/// What the gzip or zlib data (or deflated data without either's header) from `start` in a file
/// expands to, several gzip members one after the other included. Streams: reading forwards is
/// fast, reading backwards starts again from the beginning. Holds about 100 KB. Errors: io_error.
Result<std::unique_ptr<ByteReader>> open_deflated(const std::filesystem::path& path,
                                                  uint64_t start = 0,
                                                  Deflate kind = Deflate::gzip_or_zlib);

/// Whether a file begins with gzip's magic number.
bool is_gzip(const std::filesystem::path& path);

/// The size of a regular file. Errors: io_error with the system's reason, and for an empty file
/// malformed_volume.
Result<uint64_t> size_of_file(const std::filesystem::path& path);

}  // namespace isosplat
