#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>

#include "shared/base/status.h"

namespace isosplat {

/// Runs `work` in a child process and returns its answer. For libraries that print, abort or crash
/// on damaged files: what the child prints is dropped, and its death is an Error that names `path`.
/// It may use 30 minutes of processor time and map `memory_bytes` more than this process has, and
/// leaves no core file.
///
/// The child is a fork: it sees this process's memory, and what it changes is seen by nobody,
/// SharedBytes excepted. `work` must not wait for other threads, as the child has none.
///
/// Errors: those of `work`; malformed_volume where the child died; io_error where none could be
/// started.
Result<std::string> run_isolated(const std::filesystem::path& path, uint64_t memory_bytes,
                                 const std::function<Result<std::string>()>& work);

/// Memory that this process and the children that it forks afterwards share.
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

}  // namespace isosplat
