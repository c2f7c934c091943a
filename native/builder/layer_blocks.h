#pragma once

#include <condition_variable>
#include <mutex>
#include <optional>
#include <utility>

#include "shared/core/builder/store_build.h"

namespace isosplat {

/// Distributes the blocks of a layer to several threads: begins and adds blocks of the build, and
/// waits.
class LayerBlocks {
 public:
  explicit LayerBlocks(StoreBuild& build) : build_(build) {}

  /// The next block. Waits for earlier ones. No value if all were begun, if adding one has failed,
  /// or after stop().
  std::optional<BlockTask> begin() {
    std::unique_lock lock(mutex_);
    std::optional<BlockTask> task;
    changed_.wait(lock, [&] {
      if (!result_ || is_stopped_ || build_.layer_is_begun()) return true;
      task = build_.begin_block();
      return task.has_value();
    });
    return task;
  }

  /// Adds an encoded block. After the first error, nothing more is added.
  void add(size_t number, EncodedBlock&& encoded) {
    const std::lock_guard lock(mutex_);
    if (result_) result_ = build_.add_block(number, std::move(encoded));
    changed_.notify_all();
  }

  /// Loads the layer, unless it is. False after an error.
  bool load() {
    const std::lock_guard lock(mutex_);
    // Layers whose statistics are not known are loaded before: load_layer() has counted them.
    if (result_) result_ = build_.load_layer(false);
    changed_.notify_all();
    return result_.has_value();
  }

  /// Ends the build of the layer with an error.
  void fail(const Error& error) {
    const std::lock_guard lock(mutex_);
    if (result_) result_ = tl::unexpected(error);
    changed_.notify_all();
  }

  /// Ends all waits, since no more blocks will be added.
  void stop() {
    const std::lock_guard lock(mutex_);
    is_stopped_ = true;
    changed_.notify_all();
  }

  /// The first error. Call after all threads have ended.
  const Result<void>& result() const { return result_; }

 private:
  StoreBuild& build_;
  std::mutex mutex_;
  std::condition_variable changed_;
  bool is_stopped_ = false;
  Result<void> result_;
};

}  // namespace isosplat
