#pragma once

#include <cstdint>
#include <mutex>
#include <string>
#include <unordered_map>

namespace isosplat {

/// Counts open connections, overall and by address. Callable from any thread at a time.
class Admission {
 public:
  enum class Verdict {
    admitted,
    too_many,           ///< overall: 503
    too_many_from_one,  ///< from this address: 429
    ignored             ///< so many refusals are under way that this one is not worth an answer
  };

  Admission(uint32_t most, uint32_t max_per_address)
      : max_(most), max_per_address_(max_per_address) {}

  /// Counts a connection. Every verdict but ignored needs one leave() with the same arguments.
  Verdict enter(const std::string& address) {
    constexpr uint32_t kMaxRefusals = 64;
    const std::lock_guard lock(mutex_);
    Verdict verdict = Verdict::admitted;
    if (open_ >= max_) {
      verdict = Verdict::too_many;
    } else if (max_per_address_ != 0) {
      const auto found = by_address_.find(address);
      if (found != by_address_.end() && found->second >= max_per_address_) {
        verdict = Verdict::too_many_from_one;
      }
    }
    if (verdict == Verdict::admitted) {
      ++open_;
      if (max_per_address_ != 0) ++by_address_[address];
    } else if (refusals_ >= kMaxRefusals) {
      verdict = Verdict::ignored;
    } else {
      ++refusals_;
    }
    return verdict;
  }

  void leave(const std::string& address, Verdict verdict) {
    const std::lock_guard lock(mutex_);
    if (verdict != Verdict::admitted) {
      --refusals_;
      return;
    }
    --open_;
    const auto found = by_address_.find(address);
    if (found != by_address_.end() && --found->second == 0) by_address_.erase(found);
  }

 private:
  const uint32_t max_;
  const uint32_t max_per_address_;
  std::mutex mutex_;
  uint32_t open_ = 0;
  uint32_t refusals_ = 0;
  std::unordered_map<std::string, uint32_t> by_address_;
};

}  // namespace isosplat
