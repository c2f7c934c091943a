#pragma once

#include <memory>

namespace isosplat {

/// A request's work on the threads for disks, in turns: other requests have theirs in between, so
/// that a few requests with much to read do not keep all threads.
struct WorkTurn {
  struct Progress {
    virtual ~Progress() = default;
  };
  std::unique_ptr<Progress> progress;  ///< of the route's handler; null before the first turn
  bool is_unfinished = false;  ///< the handler has more to do: make the request again with this
};

}  // namespace isosplat
