#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "shared/core/store/store_writer.h"
#include "shared/system/posix_file/posix_file.h"

namespace isosplat {

/// A file that appears under its name only once it is complete. The program writes all of its files
/// in this way.
///
/// The bytes are written to a temporary file in the target's folder, which is hidden, locked and
/// has a unique name. publish() renames it. If the program ends before, the target is unchanged,
/// even after a crash. The next program that writes this target removes temporary files left by a
/// crash. If several programs write one target, each has a separate temporary file, and the last
/// one to publish wins.
///
/// If the target is a symbolic link, the file that it points to is replaced, and the link remains.
/// A replaced file keeps its permissions; a new file has those of the umask.
class OutputFile : public ByteSink {
 public:
  /// Errors: io_error (also for an existing file without write permission, and for a cycle of
  /// links), invalid_argument (the target is a folder, a device, a pipe or a socket).
  static Result<OutputFile> create(const std::filesystem::path& target);

  OutputFile(OutputFile&& other) noexcept;
  OutputFile& operator=(OutputFile&&) = delete;
  ~OutputFile() override;

  Result<void> write(uint64_t offset, std::span<const std::byte> bytes) override;

  /// Flushes the bytes to the disk, then renames the file to the target. Errors: io_error.
  Result<void> publish();

  const std::filesystem::path& temporary_path() const { return *temporary_; }

 private:
  OutputFile() = default;
  Result<void> flush();

  std::filesystem::path target_;
  std::unique_ptr<const std::filesystem::path> temporary_;  // null after publish()
  PosixFile file_;
  std::vector<std::byte> pending_;  // not yet written, from pending_offset_ on
  uint64_t pending_offset_ = 0;
};

/// Writes a file as a whole: OutputFile. Errors: those of OutputFile.
Result<void> write_whole_file(const std::filesystem::path& target,
                              std::span<const std::byte> bytes);

/// The first bytes of an existing regular file, at most `count`, for detecting the kind of a file
/// before it is replaced. Empty if there is no such file, or it cannot be read.
std::string first_bytes(const std::filesystem::path& path, size_t count);

/// Removes the temporary files that this process is writing. Async-signal-safe, for handlers of
/// signals that end the program. A child process does not remove those of its parent.
void remove_unfinished_files();

}  // namespace isosplat
