#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace isosplat::server {

class ByteBudget;

/// Numbers of stores or scenes at one moment.
struct StoreCounts {
  uint64_t served = 0;
  uint64_t broken = 0;
  uint64_t unread = 0;  ///< not read yet
  uint64_t open = 0;
  uint64_t opened = 0;  ///< so far; of scenes: not counted
};

/// Counts the server's activity, for Prometheus. HTTP.md lists the names. Thread-safe. The counters
/// in one text need not be from exactly the same moment.
class Metrics {
 public:
  Metrics();

  /// Counts a response. `route`: its index in routes(), or kNoRoute for a request that was refused
  /// before it had a route. `bytes`: of the body, as sent. `time`: from the last byte of the
  /// request to the last byte that was sent.
  void add_response(size_t route, int status, uint64_t bytes, std::chrono::nanoseconds time);
  static constexpr size_t kNoRoute = SIZE_MAX;

  // Plain counters and gauges, which the parts of the server update directly.
  std::atomic<uint64_t> connections{0};           ///< admitted so far
  std::atomic<uint64_t> connections_refused{0};   ///< above a limit, so far
  std::atomic<uint64_t> connections_open{0};      ///< now, with those that are being refused
  std::atomic<uint64_t> reads_in_memory{0};       ///< requests and pieces that needed no disk
  std::atomic<uint64_t> reads_of_disk{0};         ///< those that the disk's threads have begun
  std::atomic<uint64_t> reads_waiting{0};         ///< queued for the disk, or reading, now
  std::atomic<uint64_t> computations{0};          ///< begun by the computing threads, so far
  std::atomic<uint64_t> computations_waiting{0};  ///< queued for them, or computing, now
  std::atomic<uint64_t> computations_refused{0};  ///< requests, since too many waited, so far
  std::atomic<uint64_t> work_cancelled{
      0};  ///< requests whose client disconnected before the end, so far
  std::atomic<uint64_t> connections_closed{0};  ///< to make room for others, so far
  std::atomic<uint64_t> out_of_memory{0};   ///< operations that failed for lack of memory, so far
  std::atomic<uint64_t> faults{0};          ///< errors of the server, so far
  std::atomic<uint64_t> tls_failures{0};    ///< handshakes that failed, so far
  std::atomic<uint64_t> reloads{0};         ///< that succeeded, so far
  std::atomic<uint64_t> reloads_failed{0};  ///< so far
  std::atomic<bool> was_reload_successful{true};  ///< the last one; before it, the start
  std::atomic<int64_t> reload_time{0};            ///< of the last one, in seconds since 1970
  std::atomic<int64_t> certificate_end{0};        ///< in seconds since 1970; 0: no TLS
  std::atomic<uint64_t> log_dropped{0};           ///< lines of the log that were dropped, so far
  std::atomic<uint64_t> access_log_dropped{
      0};  ///< lines of the access log that were dropped, so far

  /// The metrics in the text format 0.0.4 of Prometheus.
  std::string text(const StoreCounts& stores, const StoreCounts& scenes,
                   const ByteBudget* bytes_in_flight) const;

  /// Counts a reload, or the start.
  void add_reload(bool is_successful);

 private:
  /// Upper limits of the histogram's buckets, in microseconds; the last bucket has none.
  static constexpr std::array<uint32_t, 13> kBuckets = {
      1'000,   2'500,   5'000,     10'000,    25'000,    50'000,    100'000,
      250'000, 500'000, 1'000'000, 2'500'000, 5'000'000, 10'000'000};
  static constexpr int kMaxStatus = 599;

  struct PerRoute {
    std::array<std::atomic<uint64_t>, kMaxStatus + 1> by_status{};
    std::array<std::atomic<uint64_t>, kBuckets.size() + 1> by_time{};
    std::atomic<uint64_t> microseconds{0};
    std::atomic<uint64_t> bytes{0};
  };

  const std::chrono::system_clock::time_point start_ = std::chrono::system_clock::now();
  std::vector<PerRoute> per_route_;  ///< those of routes(), then those without a route
};

}  // namespace isosplat::server
