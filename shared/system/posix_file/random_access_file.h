#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "shared/core/base/status.h"

namespace isosplat {

/// Identifies a file and its state. A file that replaces another one at the same path has another
/// identity.
struct FileIdentity {
  uint64_t device = 0;
  uint64_t inode = 0;
  uint64_t bytes = 0;
  int64_t modified_ns = 0;  ///< since 1970

  friend bool operator==(const FileIdentity&, const FileIdentity&) = default;

  /// Whether size and modification time are equal. For files that are open, or known by path only.
  bool has_same_content(const FileIdentity& other) const {
    return bytes == other.bytes && modified_ns == other.modified_ns;
  }
};

/// Pass a NoWait to a read that must not wait for a disk or a network. If the bytes may not be in
/// the system's memory, the read fails with io_error, and sets `needs_disk`. Then repeat the read
/// without a NoWait, on a thread that may wait.
struct NoWait {
  bool needs_disk = false;
};

/// An open file whose bytes are read by offsets: a PosixFile, or an object of a web server. Several
/// threads may read at the same time. Error messages begin with the file's name.
class RandomAccessFile {
 public:
  virtual ~RandomAccessFile() = default;

  /// For messages.
  virtual const std::string& name() const = 0;

  /// The identity of the file at this moment. Errors: io_error.
  virtual Result<FileIdentity> identity(NoWait* no_wait = nullptr) const = 0;

  /// Fills `out`. Errors: io_error; truncated if the file ends too early.
  virtual Result<void> read(uint64_t offset, std::span<std::byte> out,
                            NoWait* no_wait = nullptr) const = 0;

  /// Two reads with at most this many bytes between them take longer than one read of all bytes
  /// from the first to the last.
  virtual uint64_t max_gap_bytes() const { return 0; }

 protected:
  RandomAccessFile() = default;
  RandomAccessFile(const RandomAccessFile&) = default;
  RandomAccessFile& operator=(const RandomAccessFile&) = default;
};

}  // namespace isosplat
