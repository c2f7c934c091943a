#pragma once

#include <cstdint>
#include <memory>

namespace isosplat {

/// The work of a request that reads the headers of many stores, in turns: other requests have
/// theirs in between, so that a few requests with many to read do not keep all threads for that.
struct WorkTurn {
  struct Progress {
    virtual ~Progress() = default;
  };
  std::unique_ptr<Progress> progress;  ///< of the route's handler; null before the first turn
  bool is_unfinished = false;          ///< the handler has more to do: call it again with this turn
};

inline constexpr uint32_t kHeadersPerTurn = 16;  ///< store headers that one turn reads at most

}  // namespace isosplat
