#pragma once

#include <cstdint>
#include <memory>

namespace isosplat::server {

/// A request with much to read or to compute works in turns. Other requests have turns in between,
/// so that a few requests do not occupy all threads, and the work ends once the client has
/// disconnected.
struct WorkTurn {
  struct Progress {
    virtual ~Progress() = default;
  };
  std::unique_ptr<Progress> progress;  ///< of the route's handler; null before the first turn
  bool is_unfinished = false;          ///< the handler must be called again with this turn
};

inline constexpr uint32_t kHeadersPerTurn =
    16;  ///< maximum number of store headers to read in a turn
inline constexpr uint64_t kCellsPerTurn = 1
                                          << 20;  ///< cells to decode in a turn, and one chunk more
inline constexpr uint64_t kBytesPerTurn =
    4 << 20;  ///< bytes of chunks to read in a turn, and one chunk more

}  // namespace isosplat::server
