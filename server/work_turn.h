#pragma once

#include <cstdint>
#include <memory>

namespace isosplat {

/// A request's work on the threads that read headers, in turns: other requests have theirs in
/// between, so that a few requests with many to read do not keep all threads.
struct WorkTurn {
  struct Progress {
    virtual ~Progress() = default;
  };
  std::unique_ptr<Progress> progress;  ///< of the route's handler; null before the first turn
  bool is_unfinished = false;  ///< the handler has more to do: make the request again with this
};

inline constexpr uint32_t kHeadersPerTurn = 16;  ///< that one turn reads

}  // namespace isosplat
