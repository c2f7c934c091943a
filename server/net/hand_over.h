#pragma once

#include <sys/types.h>

#include <optional>
#include <vector>

#include "shared/core/base/status.h"

// A running server starts its successor, the program at the same path with the same arguments, and
// gives it its listening sockets. No connection is refused meanwhile: both processes accept from
// the same sockets, until the successor says that it is ready.
//
// The successor has the variable ISOSPLAT_HAND_OVER=N:M, and as descriptors 3 a pipe to its
// predecessor, then N sockets to serve and M sockets to redirect from.
namespace isosplat::server {

struct ListeningSockets {
  std::vector<int> serving;
  std::vector<int> redirecting;  ///< to https
};

struct Successor {
  pid_t process = -1;
  /// Reads one byte when the successor is ready, and the end of the file if it ends before. The
  /// caller closes it.
  int ready = -1;
};

/// Starts the successor of this process. The sockets stay open here. Errors (io_error): it cannot
/// be started.
Result<Successor> start_successor(const ListeningSockets& sockets);

/// The sockets that the predecessor of this process gave it; no value if there is none. Takes the
/// variable out of the environment, so that a second call returns none. Not thread-safe.
std::optional<ListeningSockets> take_handed_sockets();

/// Tells the predecessor, if there is one, that this process serves now.
void notify_predecessor();

}  // namespace isosplat::server
