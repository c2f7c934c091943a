#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <vector>

#include "shared/system/posix_file/posix_file.h"

namespace isosplat {

/// Bytes in a temporary file, for parts of a file that follow others whose size is not known yet.
/// The temporary file has no name, and is deleted when the program ends.
class SpooledBytes {
 public:
  /// `folder`: the folder of the temporary file; empty: the current folder. Errors: io_error.
  static Result<SpooledBytes> create(const std::filesystem::path& folder);

  /// Errors: io_error.
  Result<void> append(std::span<const std::byte> bytes);

  uint64_t size() const { return size_; }

  /// Forgets all bytes. Later ones use their space.
  void clear() { size_ = 0; }

  /// Calls `use` for pieces of all bytes, in order. Errors: io_error, and the first error of `use`.
  Result<void> read(const std::function<Result<void>(std::span<const std::byte>)>& use) const;

 private:
  explicit SpooledBytes(PosixFile file) : file_(std::move(file)) {}

  PosixFile file_;
  uint64_t size_ = 0;
};

}  // namespace isosplat
