#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "shared/import/bytes/byte_reader.h"
#include "shared/import/bytes/readable_file.h"
#include "shared/import/codecs/access_points.h"
#include "shared/import/codecs/deflated_reader.h"

namespace isosplat::import {

/// Decompresses forwards, from the beginning of the data or from an access point.
class InflateStream {
 public:
  virtual ~InflateStream() = default;

  virtual bool is_running() const = 0;

  /// Number of bytes returned since the beginning of the data.
  virtual uint64_t position() const = 0;

  /// Starts at the beginning of the data. Errors: out_of_memory.
  virtual Result<void> begin() = 0;
  virtual Result<void> begin_at(const AccessPoint& point) = 0;

  /// Decompresses up to out.size() bytes; fewer only at the regular end of the data. Adds access
  /// points if `points` is not null. Errors: io_error, truncated, malformed_volume.
  virtual Result<size_t> expand_some(std::span<std::byte> out, AccessPoints* points = nullptr) = 0;
};

/// With zlib. The file must outlive the stream.
std::unique_ptr<InflateStream> make_zlib_stream(const ReadableFile& file, uint64_t start,
                                                Deflate kind);

/// Without a library, for WebAssembly, since distributions have no zlib for it. Gives the same
/// bytes and errors as make_zlib_stream.
std::unique_ptr<InflateStream> make_plain_inflate_stream(const ReadableFile& file, uint64_t start,
                                                         Deflate kind);

}  // namespace isosplat::import
