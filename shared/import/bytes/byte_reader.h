#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "shared/core/base/status.h"

namespace isosplat::import {

/// Random access to bytes: a file, or the decompressed data of a file. Not thread-safe.
class ByteReader {
 public:
  virtual ~ByteReader() = default;

  /// Reads out.size() bytes from `offset`. Errors: truncated if there are fewer bytes, io_error,
  /// malformed_volume if compressed data are damaged.
  virtual Result<void> read(uint64_t offset, std::span<std::byte> out) = 0;

  /// Whether reading bytes costs about the same at any offset, in any order. False for compressed
  /// data.
  virtual bool is_random_access() const { return false; }

  /// Upper limit of the number of bytes: exact for plain files, an upper bound for compressed ones
  /// (deflate expands at most 1032 times).
  virtual uint64_t size_limit() const = 0;

  /// Number of bytes after `offset`, counted up to `max_count`. Compressed data are decompressed
  /// for this; at their end the checksum is verified. Errors: those of read.
  virtual Result<uint64_t> count_after(uint64_t offset, uint64_t max_count) = 0;

  /// Number of bytes that can be read before an error or the end. Decompresses all compressed data.
  virtual uint64_t available_bytes() = 0;

  /// The maximum memory that it keeps between reads, apart from buffers below 1 MB.
  virtual uint64_t resident_bytes() const { return 0; }

  /// The files from which the bytes are read.
  virtual std::vector<std::filesystem::path> files() const = 0;
};

/// Opens an uncompressed file. Errors: io_error.
Result<std::unique_ptr<ByteReader>> open_plain(const std::filesystem::path& path);

/// The first bytes of a file, up to `limit`, for formats with text headers. Errors: io_error.
Result<std::string> read_beginning(const std::filesystem::path& path, size_t limit = 64 * 1024);

/// Whether a file begins with gzip's magic number.
bool is_gzip(const std::filesystem::path& path);

/// The size of a regular file. Errors: io_error with the system's reason; malformed_volume for an
/// empty file.
Result<uint64_t> size_of_file(const std::filesystem::path& path);

/// The sizes of all files; those that cannot be read count as 0.
uint64_t total_bytes(const std::vector<std::filesystem::path>& files);

}  // namespace isosplat::import
