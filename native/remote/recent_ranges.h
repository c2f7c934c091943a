#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

namespace isosplat::remote {

/// The byte ranges of an object that were read last, for algorithms that read chunks in two passes.
/// Several threads may call all functions at the same time.
class RecentRanges {
 public:
  /// max_bytes: of all ranges; the oldest are dropped first.
  explicit RecentRanges(uint64_t max_bytes) : max_bytes_(max_bytes) {}

  /// Fills `out` if the bytes at `offset` lie in one of the ranges. Returns whether they do.
  bool read(uint64_t offset, std::span<std::byte> out) const;

  /// Keeps a range, unless it is larger than a quarter of max_bytes.
  void add(uint64_t offset, std::vector<std::byte> bytes);

 private:
  struct Range {
    uint64_t offset = 0;
    std::vector<std::byte> bytes;
  };

  const uint64_t max_bytes_;
  mutable std::mutex mutex_;
  std::deque<std::shared_ptr<const Range>> ranges_;  // the newest last
  uint64_t bytes_ = 0;                               // of ranges_
};

}  // namespace isosplat::remote
