#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <list>
#include <mutex>
#include <optional>
#include <string>
#include <unordered_map>

namespace isosplat::server {

/// Limits the requests and bytes per second of each address, with two token buckets. A bucket holds
/// kBurst of its rate, so that the many requests of a first picture succeed. A response may be
/// larger than the rest of the bucket: the address then waits until the debt is paid. Thread-safe.
class RateLimit {
 public:
  using Clock = std::chrono::steady_clock;

  /// The rates at which the buckets are filled, per second; 0: no limit.
  struct Rates {
    double requests = 0;
    double bytes = 0;
  };
  explicit RateLimit(Rates rates) : rates_(rates) {}

  bool is_on() const { return rates_.requests > 0 || rates_.bytes > 0; }

  /// Takes a request from the address's bucket. If a bucket is empty, takes nothing and returns the
  /// number of seconds until another request will be admitted (at least 1).
  std::optional<uint32_t> take_request(const std::string& address, Clock::time_point now) {
    if (!is_on()) return std::nullopt;
    const std::lock_guard lock(mutex_);
    Buckets& buckets = fill(address, now);
    double wait = 0;
    if (rates_.requests > 0 && buckets.requests < 1) {
      wait = (1 - buckets.requests) / rates_.requests;
    }
    if (rates_.bytes > 0 && buckets.bytes < 0) wait = std::max(wait, -buckets.bytes / rates_.bytes);
    if (wait > 0) return static_cast<uint32_t>(std::clamp(std::ceil(wait), 1.0, 3600.0));
    buckets.requests -= 1;
    return std::nullopt;
  }

  /// Takes the bytes of a response before they are sent, since parallel requests share one bucket.
  void take_bytes(const std::string& address, uint64_t bytes, Clock::time_point now) {
    if (rates_.bytes <= 0 || bytes == 0) return;
    const std::lock_guard lock(mutex_);
    fill(address, now).bytes -= static_cast<double>(bytes);
  }

  static constexpr std::chrono::seconds kBurst{10};

  /// The maximum number of addresses to remember. Beyond it, the address with the oldest request is
  /// forgotten.
  static constexpr size_t kMaxAddresses = 65'536;
  size_t addresses() const {
    const std::lock_guard lock(mutex_);
    return by_address_.size();
  }

 private:
  struct Buckets {
    std::string address;
    double requests;
    double bytes;
    Clock::time_point filled;
  };
  using Entries = std::list<Buckets>;

  /// The address's buckets, filled up to now. The caller must hold mutex_.
  Buckets& fill(const std::string& address, Clock::time_point now) {
    const double burst = std::chrono::duration<double>(kBurst).count();
    // The bucket holds at least one request, even at very low rates.
    const double most_requests = std::max(rates_.requests * burst, 1.0);
    const double most_bytes = rates_.bytes * burst;
    const auto found = by_address_.find(address);
    if (found == by_address_.end()) {
      if (by_address_.size() >= kMaxAddresses) {
        by_address_.erase(entries_.back().address);
        entries_.pop_back();
      }
      entries_.push_front({address, most_requests, most_bytes, now});
      by_address_.emplace(address, entries_.begin());
      return entries_.front();
    }
    entries_.splice(entries_.begin(), entries_, found->second);
    Buckets& buckets = entries_.front();
    const double seconds =
        std::max(std::chrono::duration<double>(now - buckets.filled).count(), 0.0);
    buckets.requests = std::min(buckets.requests + seconds * rates_.requests, most_requests);
    buckets.bytes = std::min(buckets.bytes + seconds * rates_.bytes, most_bytes);
    buckets.filled = std::max(buckets.filled, now);
    return buckets;
  }

  const Rates rates_;
  mutable std::mutex mutex_;
  Entries entries_;  // guarded by mutex_; latest first
  std::unordered_map<std::string, Entries::iterator> by_address_;  // guarded by mutex_
};

}  // namespace isosplat::server
