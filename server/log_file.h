#pragma once

#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>

#include "shared/base/status.h"

namespace isosplat {

/// A log file that a thread of its own writes: those who log never wait for its disk. If the disk
/// is slower than the log for long, or full, lines are dropped and counted. Thread-safe.
class LogFile {
 public:
  /// Opens the file, to append to it; others than its owner and group cannot read it. "-": the
  /// standard output. Errors: io_error.
  static Result<std::unique_ptr<LogFile>> open(const std::filesystem::path& path);

  /// Writes what is left.
  ~LogFile();
  LogFile(const LogFile&) = delete;
  LogFile& operator=(const LogFile&) = delete;

  /// Adds a line, given without its line break.
  void add(std::string_view line);

  /// Opens the path anew, after the file was moved away. If that fails, the old one stays. Errors:
  /// io_error.
  Result<void> reopen();

  /// Lines that were dropped, or that could not be written, so far.
  uint64_t lost() const;

  /// Lines wait in memory up to this size.
  static constexpr size_t kMaxBytes = 1 << 20;

 private:
  LogFile(std::filesystem::path path, int descriptor);
  void write_until_closed();

  const std::filesystem::path path_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::string waiting_;              // guarded by mutex_
  uint64_t lost_ = 0;                // guarded by mutex_
  std::shared_ptr<const int> file_;  // guarded by mutex_; closes the descriptor at last
  bool is_closing_ = false;          // guarded by mutex_
  std::thread writer_;
};

}  // namespace isosplat
