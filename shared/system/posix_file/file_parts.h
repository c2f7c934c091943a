#pragma once

#include <memory>
#include <span>
#include <vector>

#include "shared/system/posix_file/random_access_file.h"

namespace isosplat {

/// A sequence of bytes that lies in one or several ranges of a file, such as a store in a bundle.
/// Copies share the open file. Several threads may read at the same time.
class FileParts {
 public:
  struct Part {
    uint64_t offset = 0;  ///< in the sequence; that of the first part is 0
    uint64_t file_offset = 0;
    uint64_t bytes = 0;  ///< not 0; the next part follows
  };

  /// All of a file that has this many bytes.
  FileParts(std::shared_ptr<const RandomAccessFile> file, uint64_t bytes);
  /// Parts of a file, ascending and without gaps in the sequence.
  FileParts(std::shared_ptr<const RandomAccessFile> file, std::vector<Part> parts);

  /// A range of this sequence. Requires offset + bytes ≤ bytes().
  FileParts range(uint64_t offset, uint64_t bytes) const;

  uint64_t bytes() const { return bytes_; }
  const RandomAccessFile& file() const { return *file_; }

  /// Fills `out` with the bytes at `offset`. Errors: io_error; truncated if there are fewer.
  Result<void> read(uint64_t offset, std::span<std::byte> out, NoWait* no_wait = nullptr) const;

 private:
  std::shared_ptr<const RandomAccessFile> file_;
  std::vector<Part> parts_;
  uint64_t bytes_ = 0;
};

}  // namespace isosplat
