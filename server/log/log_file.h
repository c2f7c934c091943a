#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string_view>
#include <thread>

#include "shared/core/base/status.h"

namespace isosplat::server {

/// A log that a separate thread writes: to a file, a pipe, or the program's standard output or
/// error. Callers never wait for it, and no error of it ends the program: lines that cannot be
/// written (a full disk, a pipe without a reader, a reader that is slow for long) are dropped and
/// counted. Thread-safe.
class LogFile {
 public:
  /// Opens the file for appending. Only its owner and group can read it. "-": the standard output.
  /// Errors: io_error.
  static Result<std::unique_ptr<LogFile>> open(const std::filesystem::path& path);

  static std::unique_ptr<LogFile> standard_output();
  static std::unique_ptr<LogFile> standard_error();

  /// Writes the remaining lines, for at most kClosingTime.
  ~LogFile();
  LogFile(const LogFile&) = delete;
  LogFile& operator=(const LogFile&) = delete;

  /// Adds a line, given without its line break.
  void add(std::string_view line);

  /// Opens the path again, after the file was moved away. If this fails, the previous file stays in
  /// use. Errors: io_error.
  Result<void> reopen();

  /// Lines that were dropped so far.
  uint64_t dropped() const;

  /// The maximum bytes of lines that wait in memory.
  static constexpr size_t kMaxBytes = 1 << 20;
  static constexpr std::chrono::milliseconds kClosingTime{1000};

 private:
  struct State;
  LogFile(std::filesystem::path path, int descriptor);

  const std::filesystem::path path_;  ///< empty: the file was not opened by this class
  std::shared_ptr<State> state_;      ///< with the thread, which a file may block for ever
  std::thread writer_;
};

}  // namespace isosplat::server
