#pragma once

#include <atomic>
#include <cstddef>
#include <thread>
#include <vector>

namespace isosplat {

/// Calls f(thread, index) for every index below `count`, on up to `threads` threads, each index
/// once; threads take the next index when they are free. Returns when all calls have returned.
template <class F>
void parallel_for(unsigned threads, size_t count, F f) {
  if (threads <= 1 || count <= 1) {
    for (size_t i = 0; i < count; ++i) f(0u, i);
    return;
  }
  std::atomic<size_t> next{0};
  const auto work = [&](unsigned thread) {
    for (size_t i = next++; i < count; i = next++) f(thread, i);
  };
  std::vector<std::thread> others;
  for (unsigned t = 1; t < threads && t < count; ++t) others.emplace_back(work, t);
  work(0);
  for (std::thread& other : others) other.join();
}

}  // namespace isosplat
