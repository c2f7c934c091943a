#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <limits>
#include <list>

namespace isosplat {

class Connection;

/// The connections of a thread that wait for a request, or for the rest of one, in the order in
/// which they began. If the server is full, those that have waited longest are closed. All
/// functions except longest_since() run on the connections' thread.
class WaitingConnections {
 public:
  struct Entry {
    Connection* connection;
    int64_t since;  ///< ticks of the steady clock
  };
  using Place = std::list<Entry>::iterator;

  /// Adds a connection that begins to wait now.
  Place add(Connection* connection) {
    const int64_t now = std::chrono::steady_clock::now().time_since_epoch().count();
    const Place place = entries_.insert(entries_.end(), {connection, now});
    publish();
    return place;
  }

  void remove(Place place) {
    entries_.erase(place);
    publish();
  }

  /// The connection that has waited longest; null if none waits.
  Connection* longest() const { return entries_.empty() ? nullptr : entries_.front().connection; }

  /// Since when it waits (ticks of the steady clock); kNone if none waits. Thread-safe.
  int64_t longest_since() const { return longest_since_.load(std::memory_order_relaxed); }
  static constexpr int64_t kNone = std::numeric_limits<int64_t>::max();

 private:
  void publish() {
    longest_since_.store(entries_.empty() ? kNone : entries_.front().since,
                         std::memory_order_relaxed);
  }

  std::list<Entry> entries_;
  std::atomic<int64_t> longest_since_{kNone};
};

}  // namespace isosplat
