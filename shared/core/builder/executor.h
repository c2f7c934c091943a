#pragma once

#include <cstddef>
#include <functional>

namespace isosplat {

/// Runs independent parts of a computation, perhaps in parallel.
class Executor {
 public:
  virtual ~Executor() = default;

  /// How many threads may run parts at the same time, ≥ 1.
  virtual unsigned threads() const = 0;

  /// Calls part(thread, index) once for every index below `count`, and returns when all calls have
  /// returned. thread: below threads(); calls with the same number do not overlap.
  virtual void run(size_t count,
                   const std::function<void(unsigned thread, size_t index)>& part) = 0;
};

/// Runs all parts on the calling thread.
class SerialExecutor : public Executor {
 public:
  unsigned threads() const override { return 1; }
  void run(size_t count, const std::function<void(unsigned, size_t)>& part) override {
    for (size_t i = 0; i < count; ++i) part(0, i);
  }
};

}  // namespace isosplat
