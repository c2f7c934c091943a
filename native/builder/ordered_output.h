#pragma once

#include <condition_variable>
#include <mutex>
#include <optional>
#include <vector>

#include "native/builder/block_worker.h"
#include "shared/preprocess/size_budget.h"
#include "shared/store/format.h"

namespace isosplat {

/// Takes the blocks of a layer in any order, from any thread, hands them to the writer in theirs,
/// and says from the sizes of those before what each may take.
class OrderedOutput {
 public:
  /// Of the blocks (x, y, z) of a level, in raster order. A block waits until all but `at_a_time`
  /// − 1 of those before it are written, so that what it is granted does not depend on threads.
  OrderedOutput(StoreWriter& writer, SizeBudget& budget, const LevelGrid& grid, int32_t z,
                size_t at_a_time)
      : writer_(writer),
        budget_(budget),
        grid_(grid),
        z_(z),
        at_a_time_(at_a_time),
        ready_(static_cast<size_t>(grid.blocks.x) * static_cast<size_t>(grid.blocks.y)) {
    grants_.push_back(budget.grant());
  }

  Index3 index_of(size_t block) const {
    const auto n = static_cast<int32_t>(block);
    return {n % grid_.blocks.x, n / grid_.blocks.x, z_};
  }

  /// What a block may take. Waits; nothing where the output has failed or was stopped.
  std::optional<SizeBudget::Grant> grant(size_t block) {
    std::unique_lock lock(mutex_);
    const size_t before = block + 1 > at_a_time_ ? block + 1 - at_a_time_ : 0;
    changed_.wait(lock, [&] { return next_ >= before || !result_ || is_stopped_; });
    if (!result_ || is_stopped_) return std::nullopt;
    return grants_[before];
  }

  /// There will be no more blocks: nobody waits for them.
  void stop() {
    const std::lock_guard lock(mutex_);
    is_stopped_ = true;
    changed_.notify_all();
  }

  /// Keeps the first error, and nothing after it.
  void put(size_t block, EncodedBlock&& encoded) {
    const std::lock_guard lock(mutex_);
    ready_[block] = std::move(encoded);
    for (; next_ < ready_.size() && ready_[next_]; ++next_) {
      const EncodedBlock& first = *ready_[next_];
      if (result_) result_ = writer_.add_block(first.interval, first.bands, first.bytes);
      const size_t records = kBlockRecordBytes + kChunkRecordBytes * first.bands.size();
      budget_.add(grid_.level, index_of(next_), first.storage_weight,
                  static_cast<double>(first.bytes.size() + records));
      grants_.push_back(budget_.grant());
      ready_[next_].reset();
    }
    changed_.notify_all();
  }

  bool has_failed() {
    const std::lock_guard lock(mutex_);
    return !result_;
  }

  /// Once every block was put.
  const Result<void>& result() const { return result_; }

 private:
  StoreWriter& writer_;
  SizeBudget& budget_;
  const LevelGrid grid_;
  const int32_t z_;
  const size_t at_a_time_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<std::optional<EncodedBlock>> ready_;
  std::vector<SizeBudget::Grant> grants_;  // after so many blocks
  size_t next_ = 0;
  bool is_stopped_ = false;
  Result<void> result_;
};

}  // namespace isosplat
