#include "server/file_follower.h"

#include <algorithm>
#include <chrono>
#include <new>

namespace isosplat::server {

/// Watches the files of stores, scenes and page until the server stops.
void FileFollower::follow() {
  using Clock = std::chrono::steady_clock;
  Clock::time_point next = Clock::now();
  std::string read_up_to, scenes_read_up_to;
  bool are_headers_read = false;
  while (!stopping_) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(next - Clock::now());
    const bool has_changed = catalog_.follow(
        are_headers_read ? std::clamp(left, {}, options_.scan_interval) : decltype(left){0});
    if (has_changed) {
      read_up_to.clear();
      scenes_read_up_to.clear();
      are_headers_read = false;
    }
    if (!are_headers_read) {
      are_headers_read = read_headers(ServedKind::volume, read_up_to) &&
                         read_headers(ServedKind::scene, scenes_read_up_to);
    }
    if (Clock::now() < next && !has_changed) continue;
    stores_.trim(*catalog_.snapshot());
    if (Clock::now() < next) continue;
    if (examine_scenes()) are_headers_read = false;
    router_.count_files();
    page_.load_if_changed();
    metrics_.log_dropped = log_.dropped();
    metrics_.access_log_dropped = log_.access_dropped();
    next = Clock::now() + options_.scan_interval;
  }
}

void FileFollower::run() {
  while (!stopping_) {
    try {
      follow();
    } catch (const std::bad_alloc&) {
      ++metrics_.out_of_memory;
      std::this_thread::sleep_for(options_.scan_interval);
    }
  }
}

/// Replaces the entries of scenes whose stores have changed. Returns whether there are any.
bool FileFollower::examine_scenes() {
  const auto changed = scenes_.examine(*catalog_.snapshot(ServedKind::scene));
  if (!changed.empty()) catalog_.renew_scenes(changed);
  return !changed.empty();
}

/// Reads headers of stores or scenes that have not been read yet, so that searches find titles at
/// once and the log names stores that cannot be served. Returns after a short time, with whether
/// all were read. `done`: the name at which the last call stopped.
bool FileFollower::read_headers(ServedKind kind, std::string& done) {
  const auto snapshot = catalog_.snapshot(kind);
  using Clock = std::chrono::steady_clock;
  const Clock::time_point end = Clock::now() + std::chrono::milliseconds(50);
  for (auto item = done.empty() ? snapshot->begin() : snapshot->upper_bound(done);
       item != snapshot->end(); ++item) {
    if (stopping_ || Clock::now() > end) return false;
    if (kind == ServedKind::volume) {
      stores_.summary(*item->second);
    } else {
      scenes_.summary(*item->second);
    }
    done = item->first;
  }
  done.clear();
  return true;
}

}  // namespace isosplat::server
