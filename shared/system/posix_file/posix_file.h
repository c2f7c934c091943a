#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "shared/system/posix_file/random_access_file.h"

namespace isosplat {

/// The identity of the regular file at a path. Errors: io_error, also for folders, pipes and
/// devices.
Result<FileIdentity> file_identity(const std::filesystem::path& path);

/// An open file; the destructor closes it. Reads and writes have offsets, so that several threads
/// may use a file at the same time. Repeats system calls that a signal interrupted, and completes
/// short reads and writes. Error messages begin with the file's name.
class PosixFile final : public RandomAccessFile {
 public:
  /// No file: is_open() is false, and nothing else may be called.
  PosixFile() = default;

  /// Opens a regular file for reading. Never waits for the other end of a pipe. Errors: io_error,
  /// also for folders, pipes and devices.
  static Result<PosixFile> open(const std::filesystem::path& path);

  /// Creates a file without a path, for reading and writing. The system removes it when the program
  /// ends, also after a crash. Errors: io_error.
  static Result<PosixFile> create_temporary(const std::filesystem::path& folder);

  /// Takes ownership of an open descriptor. name: for messages.
  PosixFile(int descriptor, std::string name);

  PosixFile(PosixFile&& other) noexcept;
  PosixFile& operator=(PosixFile&& other) noexcept;
  ~PosixFile() override;

  bool is_open() const { return descriptor_ >= 0; }
  int descriptor() const { return descriptor_; }

  const std::string& name() const override { return name_; }
  void set_name(std::string name) { name_ = std::move(name); }

  Result<FileIdentity> identity(NoWait* no_wait = nullptr) const override;

  /// Reads out.size() bytes, or fewer if the file ends. Returns their number. Errors: io_error.
  Result<size_t> read_some(uint64_t offset, std::span<std::byte> out,
                           NoWait* no_wait = nullptr) const;

  Result<void> read(uint64_t offset, std::span<std::byte> out,
                    NoWait* no_wait = nullptr) const override;

  /// Writes all bytes. Errors: io_error.
  Result<void> write(uint64_t offset, std::span<const std::byte> bytes);

  /// Waits until what was written is on the disk. Errors: io_error.
  Result<void> synchronize();

  void close();

 private:
  /// How the file system reports that a read would have to wait.
  enum class Waits : uint8_t {
    reported,  ///< it reports whether the bytes are in memory (ext4, XFS, Btrfs)
    never,     ///< all files are in memory (tmpfs)
    unknown    ///< it does not report this (network and user-space file systems)
  };
  static Waits waits_of(int descriptor);

  std::string name_;
  int descriptor_ = -1;
  Waits waits_ = Waits::unknown;
};

/// io_error with the text of an errno value: "NAME: cannot be ACTION: TEXT". For a full disk, the
/// message also states the remedy. `action`: a past participle, such as "opened".
tl::unexpected<Error> file_error(int number, const std::string& name, const char* action);

}  // namespace isosplat
