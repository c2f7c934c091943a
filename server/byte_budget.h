#pragma once

#include <atomic>
#include <cstdint>

namespace isosplat {

/// The memory of the bodies that are being sent, of all connections together. Thread-safe.
class ByteBudget {
 public:
  explicit ByteBudget(uint64_t bytes) : limit_(bytes) {}

  /// A part of the budget, until it is destroyed.
  class Share {
   public:
    Share() = default;
    Share(const Share&) = delete;
    Share& operator=(const Share&) = delete;
    ~Share() {
      if (budget_) budget_->used_ -= bytes_;
    }

    /// Takes this many bytes. False if fewer are left, unless nothing else is in use: a body larger
    /// than the budget is sent alone. Call once.
    bool take(ByteBudget& budget, uint64_t bytes) {
      const uint64_t before = budget.used_.fetch_add(bytes);
      if (before > 0 && (before > budget.limit_ || bytes > budget.limit_ - before)) {
        budget.used_ -= bytes;
        return false;
      }
      budget_ = &budget;
      bytes_ = bytes;
      return true;
    }

   private:
    ByteBudget* budget_ = nullptr;
    uint64_t bytes_ = 0;
  };

  uint64_t used() const { return used_; }

 private:
  const uint64_t limit_;
  std::atomic<uint64_t> used_{0};
};

}  // namespace isosplat
