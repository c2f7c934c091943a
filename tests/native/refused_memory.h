#pragma once

#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <new>

// Makes allocations of working threads fail. It replaces the program's operator new, so only one
// source of a program may include it.
namespace {

/// The number of allocations that still succeed in threads other than the test's thread; the next
/// one fails. Negative: all succeed.
std::atomic<int64_t> allocations_left{-1};
thread_local bool is_test_thread = false;

bool is_refused() {
  if (is_test_thread) return false;
  int64_t left = allocations_left;
  while (left >= 0 && !allocations_left.compare_exchange_weak(left, left - 1)) {
  }
  return left == 0;
}

}  // namespace

// Replaces the program's operator, so that all allocations of the library and of the tests by `new`
// call this one.
[[gnu::noinline]] void* operator new(std::size_t bytes) {
  if (!is_refused()) {
    if (void* memory = std::malloc(bytes > 0 ? bytes : 1)) return memory;
  }
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}
