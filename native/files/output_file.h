#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "shared/posix_file/posix_file.h"
#include "shared/store/store_writer.h"

namespace isosplat {

/// A file that appears under its name only when it is whole: every file that the program makes.
///
/// It is written as a hidden, locked temporary of a unique name in its target's folder, which
/// publish() renames. However the program ends before, the target is as it was, and a file that
/// somebody else keeps is never touched. What a dead program leaves, if remove_unfinished_files()
/// was not called, is removed by the next one that writes this target. Of several programs that
/// write one target, each writes a file of its own, and the last to publish wins.
///
/// A target that is a link stays one: the file that it leads to is replaced. A file that is
/// replaced keeps its permissions; a new one gets those of the umask.
class OutputFile : public ByteSink {
 public:
  /// Errors: io_error (with what to do; also for an existing file that may not be written to, and a
  /// link that leads in a circle), invalid_argument (the target is a folder, a device, a pipe or a
  /// socket).
  static Result<OutputFile> create(const std::filesystem::path& target);

  OutputFile(OutputFile&& other) noexcept;
  OutputFile& operator=(OutputFile&&) = delete;
  ~OutputFile() override;

  Result<void> write(uint64_t offset, std::span<const std::byte> bytes) override;

  /// Makes the bytes durable, then gives them the target's name. Errors: io_error.
  Result<void> publish();

  const std::filesystem::path& temporary_path() const { return *temporary_; }

 private:
  OutputFile() = default;
  Result<void> flush();

  std::filesystem::path target_;
  std::unique_ptr<const std::filesystem::path> temporary_;  // null once it is published
  PosixFile file_;
  std::vector<std::byte> pending_;  // not yet written, from pending_offset_ on
  uint64_t pending_offset_ = 0;
};

/// The first bytes of an existing regular file, at most `count`; empty where there is none, or it
/// cannot be read. For a look at what an output would replace.
std::string first_bytes(const std::filesystem::path& path, size_t count);

/// Removes the temporaries of the files that this process is writing: for a handler of signals that
/// end the program, and safe there. A child process does not remove those of its parent.
void remove_unfinished_files();

}  // namespace isosplat
