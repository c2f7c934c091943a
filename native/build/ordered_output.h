#pragma once

#include <mutex>
#include <optional>
#include <vector>

#include "native/build/block_worker.h"

namespace isosplat {

/// Takes blocks in any order, from any thread, and hands them to the writer in theirs.
class OrderedOutput {
 public:
  OrderedOutput(StoreWriter& writer, size_t blocks) : writer_(writer), ready_(blocks) {}

  /// Keeps the first error, and nothing after it.
  void put(size_t index, EncodedBlock&& block) {
    const std::lock_guard lock(mutex_);
    ready_[index] = std::move(block);
    for (; next_ < ready_.size() && ready_[next_]; ++next_) {
      const EncodedBlock& encoded = *ready_[next_];
      if (result_) result_ = writer_.add_block(encoded.interval, encoded.slabs, encoded.bytes);
      ready_[next_].reset();
    }
  }

  bool has_failed() {
    const std::lock_guard lock(mutex_);
    return !result_;
  }

  /// Once every block was put.
  const Result<void>& result() const { return result_; }

 private:
  StoreWriter& writer_;
  std::mutex mutex_;
  std::vector<std::optional<EncodedBlock>> ready_;
  size_t next_ = 0;
  Result<void> result_;
};

}  // namespace isosplat
