#pragma once

#include "native/builder/parallel.h"
#include "shared/core/builder/executor.h"

namespace isosplat {

/// Runs parts on threads. A thread's exception is rethrown, see parallel_for.
class ThreadExecutor : public Executor {
 public:
  explicit ThreadExecutor(unsigned threads) : threads_(threads) {}
  unsigned threads() const override { return threads_; }
  void run(size_t count, const std::function<void(unsigned, size_t)>& part) override {
    parallel_for(threads_, count, part);
  }

 private:
  unsigned threads_;
};

}  // namespace isosplat
