#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "native/files/output_file.h"

struct archive;

namespace isosplat {

/// Writes a ZIP archive to a file, entry by entry. Entries of more than 4 GiB are in ZIP64.
class ZipWriter {
 public:
  enum class Compression { store, deflate };

  /// `file` must outlive the writer; the archive begins at its first byte.
  ZipWriter(OutputFile& file, Compression compression);
  ZipWriter(const ZipWriter&) = delete;
  ZipWriter& operator=(const ZipWriter&) = delete;

  /// Begins an entry, whose content is the next `size` bytes given to append(). Errors: io_error.
  Result<void> begin_entry(const char* name, uint64_t size);

  /// Errors: io_error.
  Result<void> append(std::span<const std::byte> bytes);
  Result<void> append(std::string_view text) { return append(std::as_bytes(std::span(text))); }

  /// Writes the directory of the archive. Errors: io_error.
  Result<void> close();

  /// The bytes written so far; after close(), the size of the archive.
  uint64_t bytes() const { return end_; }

 private:
  Result<void> check(int64_t returned);

  OutputFile& file_;
  uint64_t end_ = 0;
  Result<void> written_;
  std::unique_ptr<archive, int (*)(archive*)> archive_;
};

}  // namespace isosplat
