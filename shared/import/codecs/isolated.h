#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>

#include "shared/core/base/status.h"

namespace isosplat::import {

/// Runs `function` in a child process and returns its result. It is for libraries that print, abort
/// or crash on damaged files: the child's output is discarded; if the child dies, the result is an
/// error that contains `path`. The child may use 30 minutes of processor time and map
/// `memory_bytes` more than this process, and writes no core file.
///
/// The child is a fork: it sees this process's memory, but its changes are not visible here, except
/// in SharedBytes. `function` must not wait for other threads, since the child has none.
///
/// Errors: those of `function`; malformed_volume if the child died; io_error if it could not be
/// started.
Result<std::string> run_isolated(const std::filesystem::path& path, uint64_t memory_bytes,
                                 const std::function<Result<std::string>()>& function);

/// Memory that this process shares with the children that it forks afterwards.
class SharedBytes {
 public:
  /// Errors: out_of_memory.
  static Result<SharedBytes> allocate(size_t size);

  SharedBytes(SharedBytes&& other) noexcept;
  SharedBytes& operator=(SharedBytes&& other) noexcept;
  ~SharedBytes();

  std::span<std::byte> bytes() const { return bytes_; }

 private:
  explicit SharedBytes(std::span<std::byte> bytes) : bytes_(bytes) {}
  std::span<std::byte> bytes_;
};

}  // namespace isosplat::import
