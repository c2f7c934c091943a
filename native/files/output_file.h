#pragma once

#include <filesystem>
#include <memory>

#include "shared/store/store_writer.h"

namespace isosplat {

/// A file that appears under its name only when it is whole. It is written as a hidden, locked
/// temporary beside its target, which publish() renames. However the program ends before, the
/// target is as it was. What a dead build leaves, if remove_unfinished_files() was not called, is
/// removed by the next build of that target.
class OutputFile : public ByteSink {
 public:
  /// Errors: io_error (with what to do), invalid_argument (the target is a folder or a device).
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
  int file_ = -1;
  std::vector<std::byte> pending_;  // not yet written, from pending_offset_ on
  uint64_t pending_offset_ = 0;
};

/// Removes the temporaries of the files that are being written: for a handler of signals that end
/// the program, and safe there.
void remove_unfinished_files();

}  // namespace isosplat
