#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string_view>
#include <utility>

namespace isosplat {

/// The logs of a server. Thread-safe.
class ServerLog {
 public:
  using Line = std::function<void(std::string_view line)>;

  /// `log`, `access_log`: called with each line, without a line break, one call at a time. May be
  /// empty.
  ServerLog(Line log, Line access_log) : log_(std::move(log)), access_log_(std::move(access_log)) {}

  /// Logs a line about stores or the page.
  void line(std::string_view text) {
    if (!log_) return;
    const std::lock_guard lock(mutex_);
    log_(text);
  }

  /// Logs a fault. Limited to a few lines per second, since a client can request a broken store as
  /// often as it likes.
  void fault(std::string_view text) {
    if (!log_) return;
    constexpr uint32_t kLinesPerSecond = 10;
    const auto second = std::chrono::floor<std::chrono::seconds>(Clock::now());
    const std::lock_guard lock(mutex_);
    if (second != fault_second_) {
      fault_second_ = second;
      faults_this_second_ = 0;
    }
    if (++faults_this_second_ <= kLinesPerSecond) log_(text);
  }

  bool has_access_log() const { return static_cast<bool>(access_log_); }

  /// Logs a response. Requires has_access_log().
  void access(std::string_view text) {
    const std::lock_guard lock(mutex_);
    access_log_(text);
  }

 private:
  using Clock = std::chrono::steady_clock;

  const Line log_;
  const Line access_log_;
  std::mutex mutex_;
  std::chrono::time_point<Clock, std::chrono::seconds> fault_second_;  // guarded by mutex_
  uint32_t faults_this_second_ = 0;                                    // guarded by mutex_
};

}  // namespace isosplat
