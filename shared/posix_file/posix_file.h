#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "shared/base/status.h"

namespace isosplat {

/// Which file lies at a path, and in which state. A program that replaces a file by renaming
/// another one gives the path another identity.
struct FileIdentity {
  uint64_t device = 0;
  uint64_t inode = 0;
  uint64_t bytes = 0;
  int64_t modified_ns = 0;  ///< since 1970

  friend bool operator==(const FileIdentity&, const FileIdentity&) = default;

  /// Whether a file has the size and the time of change that it had. For what is open, or known by
  /// its path alone.
  bool has_same_content(const FileIdentity& other) const {
    return bytes == other.bytes && modified_ns == other.modified_ns;
  }
};

/// The identity of the regular file at a path. Errors: io_error, also for folders, pipes and
/// devices.
Result<FileIdentity> file_identity(const std::filesystem::path& path);

/// An open file. Reads and writes at offsets, so that several threads may use it at a time; closes
/// it at the end. Calls that a signal interrupts are made again; short ones are completed. Error
/// messages begin with the file's name.
class PosixFile {
 public:
  /// No file: is_open() is false, and nothing else may be called.
  PosixFile() = default;

  /// Opens a regular file for reading. Does not wait where the path names a pipe. Errors: io_error,
  /// also for folders, pipes and devices.
  static Result<PosixFile> open(const std::filesystem::path& path);

  /// Creates a file without a path, for reading and writing: the system removes it however the
  /// program ends. Errors: io_error.
  static Result<PosixFile> create_temporary(const std::filesystem::path& folder);

  /// Takes an open descriptor over. `name`: for messages.
  PosixFile(int descriptor, std::string name);

  PosixFile(PosixFile&& other) noexcept;
  PosixFile& operator=(PosixFile&& other) noexcept;
  ~PosixFile();

  bool is_open() const { return descriptor_ >= 0; }
  int descriptor() const { return descriptor_; }

  const std::string& name() const { return name_; }
  void set_name(std::string name) { name_ = std::move(name); }

  /// As it is now. Errors: io_error.
  Result<FileIdentity> identity() const;

  /// Reads up to out.size() bytes; fewer only where the file ends. Returns how many. Errors:
  /// io_error.
  Result<size_t> read_some(uint64_t offset, std::span<std::byte> out) const;

  /// Fills `out`. Errors: io_error; truncated where the file ends before.
  Result<void> read(uint64_t offset, std::span<std::byte> out) const;

  /// Writes all bytes. Errors: io_error.
  Result<void> write(uint64_t offset, std::span<const std::byte> bytes);

  /// Waits until what was written is on the disk. Errors: io_error.
  Result<void> synchronize();

  void close();

 private:
  std::string name_;
  int descriptor_ = -1;
};

/// io_error with the text of an errno value: "NAME: cannot be ACTION: TEXT". A full disk names the
/// remedy. `action`: a past participle, "opened".
tl::unexpected<Error> file_error(int number, const std::string& name, const char* action);

}  // namespace isosplat
