#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <thread>
#include <vector>

namespace isosplat {

/// Calls f(thread) for each number below `threads`, each on a thread of its own. Returns when all
/// calls have returned.
template <class F>
void on_threads(unsigned threads, F f) {
  std::vector<std::thread> others;
  for (unsigned t = 1; t < threads; ++t) others.emplace_back(f, t);
  f(0u);
  for (std::thread& other : others) other.join();
}

/// Calls f(thread, index) for every index below `count`, on up to `threads` threads, each index
/// once; threads take the next index when they are free. Returns when all calls have returned.
template <class F>
void parallel_for(unsigned threads, size_t count, F f) {
  std::atomic<size_t> next{0};
  on_threads(static_cast<unsigned>(std::min<size_t>(threads, count)), [&](unsigned thread) {
    for (size_t i = next++; i < count; i = next++) f(thread, i);
  });
}

}  // namespace isosplat
