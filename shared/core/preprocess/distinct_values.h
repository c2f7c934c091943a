#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <vector>

namespace isosplat {

/// Collects distinct numbers, up to kMax (65536, the number of quantized values). If there are
/// more, it gives up and frees its memory. At most 2 MiB.
class DistinctValues {
 public:
  static constexpr size_t kMax = 65536;

  /// Any number but NaN. −0 counts as 0.
  void add(double value) {
    if (has_too_many_ || value == last_) return;  // neighbours are often equal
    last_ = value;
    insert(value + 0.0);
  }

  void add(const DistinctValues& other) {
    if (other.has_too_many_) give_up();
    for (const double value : other.slots_) {
      if (value == value) add(value);
    }
  }

  /// As if more than kMax numbers had been added.
  void give_up() {
    has_too_many_ = true;
    slots_ = {};
    count_ = 0;
  }

  /// Whether there were more than kMax. Then sorted() is empty.
  bool has_too_many() const { return has_too_many_; }

  std::vector<double> sorted() const {
    std::vector<double> values;
    std::copy_if(slots_.begin(), slots_.end(), std::back_inserter(values),
                 [](double value) { return value == value; });
    std::sort(values.begin(), values.end());
    return values;
  }

 private:
  static constexpr double kFree = std::numeric_limits<double>::quiet_NaN();

  void insert(double value) {
    if (2 * count_ >= slots_.size()) grow();
    const size_t mask = slots_.size() - 1;
    // Fibonacci hashing: the upper bits of the product depend on all bits of the value.
    uint64_t bits = 0;
    std::memcpy(&bits, &value, sizeof bits);
    const uint64_t hash = bits * 0x9e3779b97f4a7c15u;
    for (size_t at = static_cast<size_t>(hash >> 32) & mask;; at = (at + 1) & mask) {
      if (slots_[at] == value) return;
      if (slots_[at] == slots_[at]) continue;
      if (count_ == kMax) return give_up();
      slots_[at] = value;
      ++count_;
      return;
    }
  }

  void grow() {
    std::vector<double> before = std::move(slots_);
    slots_.assign(std::max<size_t>(2 * before.size(), 1024), kFree);
    count_ = 0;
    for (const double value : before) {
      if (value == value) insert(value);
    }
  }

  std::vector<double> slots_;  ///< a hash table; its size is a power of two, free slots are NaN
  size_t count_ = 0;
  double last_ = kFree;
  bool has_too_many_ = false;
};

}  // namespace isosplat
