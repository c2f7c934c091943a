#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>

#include "server/http/printable_text.h"
#include "server/log/log_file.h"

namespace isosplat::server {

/// The logs of a server: of stores, the page and faults, and of responses. Thread-safe.
class ServerLog {
 public:
  /// The destination of the lines of one log, without a line break.
  struct Output {
    std::function<void(std::string_view line)> call;  ///< one call at a time; empty: none
    std::shared_ptr<LogFile> file;                    ///< null: none

    explicit operator bool() const { return call || file; }
  };

  ServerLog(Output log, Output access_log)
      : log_(std::move(log)), access_log_(std::move(access_log)) {}

  /// Logs a line about stores or the page. It may contain arbitrary names of files: characters that
  /// are not printable are escaped (printable_text).
  void line(std::string_view text) {
    if (log_) write(log_, printable_text(text));
  }

  /// Logs a fault. At most a few per second are logged, since a client can request a broken store
  /// any number of times; the others are dropped.
  void fault(std::string_view text) {
    if (!log_) return;
    constexpr uint32_t kLinesPerSecond = 10;
    const auto second = std::chrono::floor<std::chrono::seconds>(Clock::now());
    {
      const std::lock_guard lock(fault_mutex_);
      if (second != fault_second_) {
        fault_second_ = second;
        faults_this_second_ = 0;
      }
      if (++faults_this_second_ > kLinesPerSecond) {
        ++faults_dropped_;
        return;
      }
    }
    line(text);
  }

  bool has_access_log() const { return static_cast<bool>(access_log_); }

  /// Logs a response. Requires has_access_log(), and a printable line.
  void access(std::string_view text) { write(access_log_, text); }

  /// Lines that were dropped so far.
  uint64_t dropped() const { return faults_dropped_ + (log_.file ? log_.file->dropped() : 0); }
  uint64_t access_dropped() const { return access_log_.file ? access_log_.file->dropped() : 0; }

 private:
  using Clock = std::chrono::steady_clock;

  void write(const Output& output, std::string_view text) {
    if (output.file) output.file->add(text);
    if (!output.call) return;
    const std::lock_guard lock(call_mutex_);
    output.call(text);
  }

  const Output log_;
  const Output access_log_;
  std::mutex call_mutex_;
  std::atomic<uint64_t> faults_dropped_{0};
  std::mutex fault_mutex_;
  std::chrono::time_point<Clock, std::chrono::seconds> fault_second_;  // guarded by fault_mutex_
  uint32_t faults_this_second_ = 0;                                    // guarded by fault_mutex_
};

}  // namespace isosplat::server
