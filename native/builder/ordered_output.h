#pragma once

#include <condition_variable>
#include <mutex>
#include <optional>
#include <vector>

#include "native/builder/block_worker.h"
#include "shared/preprocess/size_budget.h"
#include "shared/store/format.h"

namespace isosplat {

/// Receives the encoded blocks of a layer in any order, from any thread, and passes them to the
/// writer in raster order. From the sizes of the written blocks it computes the size limits of the
/// next ones.
class OrderedOutput {
 public:
  /// For the blocks (x, y, z) of a level, numbered in raster order. The grant of block i depends on
  /// exactly the first i + 1 − max_in_flight blocks, and waits until they are written. So it does
  /// not depend on the number of threads.
  OrderedOutput(StoreWriter& writer, SizeBudget& budget, const LevelGrid& grid, int32_t z,
                size_t max_in_flight)
      : writer_(writer),
        budget_(budget),
        grid_(grid),
        z_(z),
        max_in_flight_(max_in_flight),
        ready_(static_cast<size_t>(grid.blocks.x) * static_cast<size_t>(grid.blocks.y)) {
    grants_.push_back(budget.grant());
  }

  Index3 index_of(size_t block) const {
    const auto n = static_cast<int32_t>(block);
    return {n % grid_.blocks.x, n / grid_.blocks.x, z_};
  }

  /// The size grant of a block. Waits for earlier blocks. No value if the output has failed or was
  /// stopped.
  std::optional<SizeBudget::Grant> grant(size_t block) {
    std::unique_lock lock(mutex_);
    const size_t needed = block + 1 > max_in_flight_ ? block + 1 - max_in_flight_ : 0;
    changed_.wait(lock, [&] { return next_ >= needed || !result_ || is_stopped_; });
    if (!result_ || is_stopped_) return std::nullopt;
    return grants_[needed];
  }

  /// Ends all waits: no more blocks will be added.
  void stop() {
    const std::lock_guard lock(mutex_);
    is_stopped_ = true;
    changed_.notify_all();
  }

  /// Adds an encoded block. After the first error of the writer, nothing more is written.
  void add(size_t block, EncodedBlock&& encoded) {
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

  /// The first error of the writer. Call after all threads have ended.
  const Result<void>& result() const { return result_; }

 private:
  StoreWriter& writer_;
  SizeBudget& budget_;
  const LevelGrid grid_;
  const int32_t z_;
  const size_t max_in_flight_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<std::optional<EncodedBlock>> ready_;
  std::vector<SizeBudget::Grant> grants_;  // [i]: when the first i blocks were written
  size_t next_ = 0;
  bool is_stopped_ = false;
  Result<void> result_;
};

}  // namespace isosplat
