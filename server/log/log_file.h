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

/// A log that a thread of its own writes: to a file, a pipe, or the program's standard output or
/// error. Those who log never wait for it, and nothing that happens to it ends the program: lines
/// that it does not take (a full disk, a pipe without a reader, a reader that is slow for long) are
/// dropped and counted. Thread-safe.
class LogFile {
 public:
  /// Opens the file, to append to it; others than its owner and group cannot read it. "-": the
  /// standard output. Errors: io_error.
  static Result<std::unique_ptr<LogFile>> open(const std::filesystem::path& path);

  static std::unique_ptr<LogFile> standard_output();
  static std::unique_ptr<LogFile> standard_error();

  /// Writes what is left, for at most kClosingTime.
  ~LogFile();
  LogFile(const LogFile&) = delete;
  LogFile& operator=(const LogFile&) = delete;

  /// Adds a line, given without its line break.
  void add(std::string_view line);

  /// Opens the path anew, after the file was moved away. If that fails, the old one stays. Errors:
  /// io_error.
  Result<void> reopen();

  /// Lines that were dropped so far.
  uint64_t dropped() const;

  /// Lines wait in memory up to this size.
  static constexpr size_t kMaxBytes = 1 << 20;
  static constexpr std::chrono::milliseconds kClosingTime{1000};

 private:
  struct State;
  LogFile(std::filesystem::path path, int descriptor);

  const std::filesystem::path path_;  ///< empty: it was not opened by this class
  std::shared_ptr<State> state_;      ///< with the thread, which a file may hold up for ever
  std::thread writer_;
};

}  // namespace isosplat::server
