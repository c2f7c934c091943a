#pragma once

#include <cstdint>
#include <memory>

namespace isosplat::server {

/// The work of a request with much to read or to compute, in turns: other requests have theirs in
/// between, so that a few requests do not keep all threads, and it ends when the client is gone.
struct WorkTurn {
  struct Progress {
    virtual ~Progress() = default;
  };
  std::unique_ptr<Progress> progress;  ///< of the route's handler; null before the first turn
  bool is_unfinished = false;          ///< the handler has more to do: call it again with this turn
};

inline constexpr uint32_t kHeadersPerTurn = 16;     ///< store headers that one turn reads at most
inline constexpr uint64_t kCellsPerTurn = 1 << 20;  ///< that a turn decodes, and one chunk more
inline constexpr uint64_t kBytesPerTurn = 4 << 20;  ///< of chunks that one reads, and one more

}  // namespace isosplat::server
