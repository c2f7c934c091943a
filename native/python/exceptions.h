#pragma once

#include <pybind11/pybind11.h>

#include <atomic>
#include <chrono>
#include <exception>
#include <mutex>

#include "shared/core/base/status.h"

namespace isosplat::python {

/// Throws the Python exception of an error, with its message: OSError for io_error, MemoryError for
/// out_of_memory, ValueError for all others. Requires the GIL.
[[noreturn]] void raise(const Error& error);

/// The value, or raise(). Requires the GIL.
template <class T>
T value_or_raise(Result<T> result) {
  if (!result) raise(result.error());
  if constexpr (!std::is_void_v<T>) return std::move(*result);
}

/// An exception that ends work which runs without the GIL: that of Ctrl-C, or of a callback. The
/// work asks `check()`, ends with its error, and the caller of the work calls `rethrow()`. All
/// functions but `rethrow()` may be called on any thread.
class Interruption {
 public:
  /// Runs Python's handlers of signals, at most every 50 ms. They run on the main thread only: on
  /// other threads, nothing happens. An exception ends the work. Takes the GIL.
  void handle_signals();

  /// Ends the work with the current C++ exception.
  void set_current_exception();

  /// Fails once the work is to end. The error is never shown.
  Result<void> check() const;

  /// Throws the exception, if there is one. Requires the GIL.
  void rethrow();

 private:
  std::atomic<bool> is_set_{false};
  std::mutex mutex_;
  std::exception_ptr exception_;
  std::chrono::steady_clock::time_point next_check_{};
};

}  // namespace isosplat::python
