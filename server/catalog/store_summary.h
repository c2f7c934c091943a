#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "shared/core/base/status.h"

namespace isosplat::server {

/// The data that the server keeps of a store whose header it has read: a few KB at most.
struct StoreSummary {
  std::string content;         ///< hexadecimal content id; empty if there is an error
  std::string title;           ///< with small letters a to z; empty if it has none
  std::string list_item;       ///< its object in the list of volumes, JSON
  std::optional<Error> error;  ///< why it cannot be served, without the names of folders
};

/// The state of a store, as far as it is known.
enum class StoreState {
  unread,  ///< not read yet
  served,  ///< its header was read, and is valid
  broken   ///< it could not be served at the last attempt
};

/// A summary that is set once. Thread-safe.
class SummaryCell {
 public:
  StoreState state() const {
    const std::lock_guard lock(mutex_);
    if (summary_) return summary_->error ? StoreState::broken : StoreState::served;
    return passing_.empty() ? StoreState::unread : StoreState::broken;
  }

  /// Null if it is not set.
  std::shared_ptr<const StoreSummary> get() const {
    const std::lock_guard lock(mutex_);
    return summary_;
  }

  /// Sets it, unless it is set. Returns whether it was not.
  bool set(std::shared_ptr<const StoreSummary> summary) const {
    const std::lock_guard lock(mutex_);
    if (summary_) return false;
    summary_ = std::move(summary);
    return true;
  }

  /// Reports a temporary error, which is not kept. Returns whether its message differs from that of
  /// the previous temporary error.
  bool set_passing(const std::string& message) const {
    const std::lock_guard lock(mutex_);
    if (message == passing_) return false;
    passing_ = message;
    return true;
  }

 private:
  mutable std::mutex mutex_;
  mutable std::string passing_;                          // guarded by mutex_
  mutable std::shared_ptr<const StoreSummary> summary_;  // guarded by mutex_
};

}  // namespace isosplat::server
