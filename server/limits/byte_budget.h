#pragma once

#include <cstdint>
#include <mutex>
#include <string>
#include <unordered_map>

namespace isosplat::server {

/// The memory for bodies that are being sent, shared by all connections. One address may use only a
/// part of it, so that it does not keep others out. Thread-safe.
class ByteBudget {
 public:
  /// `of_one`: the maximum number of bytes for one address.
  explicit ByteBudget(uint64_t bytes, uint64_t of_one = UINT64_MAX)
      : limit_(bytes), of_one_(of_one) {}

  /// A part of the budget, which is released when the share is destroyed.
  class Share {
   public:
    Share() = default;
    Share(const Share&) = delete;
    Share& operator=(const Share&) = delete;
    ~Share() {
      if (budget_) budget_->give_back(bytes_, address_);
    }

    /// Takes this many bytes for a client at this address. Returns false if not enough are left,
    /// overall or for the address. A body that exceeds the limit itself is admitted only while
    /// nothing else is in use. Call once.
    bool take(ByteBudget& budget, uint64_t bytes, const std::string& address) {
      if (bytes == 0) return true;
      if (!budget.take(bytes, address)) return false;
      budget_ = &budget;
      bytes_ = bytes;
      address_ = address;
      return true;
    }

   private:
    ByteBudget* budget_ = nullptr;
    uint64_t bytes_ = 0;
    std::string address_;
  };

  uint64_t limit() const { return limit_; }

  uint64_t used() const {
    const std::lock_guard lock(mutex_);
    return used_;
  }

 private:
  static bool has_room(uint64_t used, uint64_t bytes, uint64_t limit) {
    return used == 0 || (used <= limit && bytes <= limit - used);
  }

  bool take(uint64_t bytes, const std::string& address) {
    const std::lock_guard lock(mutex_);
    if (!has_room(used_, bytes, limit_)) return false;
    uint64_t& its = by_address_[address];
    if (!has_room(its, bytes, of_one_)) return false;
    its += bytes;
    used_ += bytes;
    return true;
  }

  void give_back(uint64_t bytes, const std::string& address) {
    const std::lock_guard lock(mutex_);
    used_ -= bytes;
    const auto its = by_address_.find(address);
    its->second -= bytes;
    if (its->second == 0) by_address_.erase(its);
  }

  const uint64_t limit_;
  const uint64_t of_one_;
  mutable std::mutex mutex_;
  uint64_t used_ = 0;                                     // guarded by mutex_
  std::unordered_map<std::string, uint64_t> by_address_;  // guarded by mutex_
};

}  // namespace isosplat::server
