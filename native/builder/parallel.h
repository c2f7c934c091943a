#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace isosplat {

/// Calls f(0) … f(threads − 1), each on its own thread. Returns when all calls have returned. If
/// calls throw, the first exception is rethrown after the last call has ended. If a thread cannot
/// be started, throws std::system_error and does not call f at all, since calls may wait for each
/// other.
template <class F>
void on_threads(unsigned threads, F f) {
  std::mutex mutex;
  std::exception_ptr failure;
  const auto run = [&](unsigned thread) {
    try {
      f(thread);
    } catch (...) {
      const std::lock_guard lock(mutex);
      if (!failure) failure = std::current_exception();
    }
  };
  enum Start { undecided, yes, no };
  std::atomic<Start> start{undecided};
  const auto decide = [&start](Start decision) {
    start = decision;
    start.notify_all();
  };
  {
    std::vector<std::jthread> others;
    try {
      others.reserve(threads);
      for (unsigned t = 1; t < threads; ++t) {
        others.emplace_back([&, t] {
          start.wait(undecided);
          if (start == yes) run(t);
        });
      }
    } catch (...) {
      decide(no);
      throw;
    }
    decide(yes);
    run(0u);
  }
  if (failure) std::rethrow_exception(failure);
}

/// Calls f(thread, index) once for every index below `count`, on up to `threads` threads. Indices
/// are assigned dynamically. Returns when all calls have returned. After a call that throws, no
/// further index is started; the exception is rethrown.
template <class F>
void parallel_for(unsigned threads, size_t count, F f) {
  std::atomic<size_t> next{0};
  on_threads(static_cast<unsigned>(std::min<size_t>(threads, count)), [&](unsigned thread) {
    try {
      for (size_t i = next++; i < count; i = next++) f(thread, i);
    } catch (...) {
      next = count;
      throw;
    }
  });
}

}  // namespace isosplat
