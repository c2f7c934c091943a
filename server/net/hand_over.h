#pragma once

#include <sys/types.h>

#include <optional>
#include <vector>

#include "shared/core/base/status.h"

// A running server starts its successor, the program at the same path with the same arguments, and
// passes it its listening sockets. No connection is refused meanwhile: both processes accept from
// the same sockets until the successor reports that it is ready.
//
// The successor has the environment variable ISOSPLAT_HAND_OVER=N:M. Its descriptor 3 is a pipe to
// its predecessor; N sockets to serve and M sockets to redirect from follow.
namespace isosplat::server {

struct ListeningSockets {
  std::vector<int> serving;
  std::vector<int> redirecting;  ///< to https
};

struct Successor {
  pid_t process = -1;
  /// Delivers one byte when the successor is ready, or the end of the file if the successor ends
  /// before. The caller closes it.
  int ready = -1;
};

/// Starts the successor of this process. The sockets stay open here. Errors (io_error): it cannot
/// be started.
Result<Successor> start_successor(const ListeningSockets& sockets);

/// The sockets that the predecessor passed to this process; no value if there is none. Removes the
/// variable from the environment, so that a second call returns none. Not thread-safe.
std::optional<ListeningSockets> take_handed_sockets();

/// Reports to the predecessor, if there is one, that this process serves now.
void notify_predecessor();

}  // namespace isosplat::server
