#pragma once

#include <cstdint>
#include <mutex>
#include <string>
#include <unordered_map>

namespace isosplat {

/// Counts open connections, overall and by address, and refuses those above the limits.
/// Thread-safe.
class Admission {
 public:
  enum class Verdict {
    admitted,
    too_many,           ///< overall: refused with 503
    too_many_from_one,  ///< from this address: refused with 429
    ignored             ///< too many refusals are being sent: closed without a response
  };

  /// The limits of open connections. max_per_address 0: no limit.
  Admission(uint32_t max, uint32_t max_per_address)
      : max_(max), max_per_address_(max_per_address) {}

  /// The address of a trusted proxy, whose connections are those of many clients: only the limit of
  /// all connections applies.
  static constexpr const char* kOfProxy = "";

  /// Counts a new connection. If the server is full, calls `make_room`, which returns whether
  /// another connection will end soon; this one is then admitted. After each verdict except
  /// `ignored`, call leave() once with the address and this verdict when the connection ends.
  template <class MakeRoom>
  Verdict enter(const std::string& address, MakeRoom make_room) {
    constexpr uint32_t kMaxRefusals = 64;
    // Connections may be above the limit, until those that are closed have ended.
    constexpr uint32_t kMaxAbove = 64;
    const std::lock_guard lock(mutex_);
    Verdict verdict = Verdict::admitted;
    // First, so that an address at its limit does not close the connections of others.
    if (is_full(address)) {
      verdict = Verdict::too_many_from_one;
    } else if (open_ >= max_ && (open_ >= max_ + kMaxAbove || !make_room())) {
      verdict = Verdict::too_many;
    }
    if (verdict == Verdict::admitted) {
      ++open_;
      count(address);
    } else if (refusals_ >= kMaxRefusals) {
      verdict = Verdict::ignored;
    } else {
      ++refusals_;
    }
    return verdict;
  }

  /// Counts an admitted connection of kOfProxy as one of the client that the proxy has named.
  /// Returns the new verdict: `admitted` or `too_many_from_one`. Call leave() with the new address
  /// and verdict then.
  Verdict name(const std::string& address) {
    const std::lock_guard lock(mutex_);
    if (!is_full(address)) {
      count(address);
      return Verdict::admitted;
    }
    --open_;
    ++refusals_;
    return Verdict::too_many_from_one;
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
  // The caller must hold mutex_.
  bool is_full(const std::string& address) const {
    const auto found = by_address_.find(address);
    return found != by_address_.end() && found->second >= max_per_address_;
  }
  void count(const std::string& address) {
    if (max_per_address_ != 0 && address != kOfProxy) ++by_address_[address];
  }

  const uint32_t max_;
  const uint32_t max_per_address_;
  std::mutex mutex_;
  uint32_t open_ = 0;
  uint32_t refusals_ = 0;
  std::unordered_map<std::string, uint32_t> by_address_;
};

}  // namespace isosplat
