#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string_view>
#include <utility>

namespace isosplat {

/// What a server says, from any thread, one line at a time.
class ServerLog {
 public:
  using Line = std::function<void(std::string_view line)>;

  /// `log`, `access_log`: told each line, without a line break; may be empty.
  ServerLog(Line log, Line access_log) : log_(std::move(log)), access_log_(std::move(access_log)) {}

  /// About stores and the page.
  void line(std::string_view text) {
    if (!log_) return;
    const std::lock_guard lock(mutex_);
    log_(text);
  }

  /// Faults come as often as clients ask for what is broken: a few lines a second say it.
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

  bool wants_access() const { return static_cast<bool>(access_log_); }

  /// An answer. Requires wants_access().
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
