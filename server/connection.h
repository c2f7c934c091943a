#pragma once

#include <atomic>
#include <memory>
#include <string>

#include "server/asio.h"
#include "server/message.h"
#include "server/router.h"
#include "server/server.h"
#include "server/server_log.h"

namespace isosplat {

/// What every connection of a server shares. Outlives them.
struct ConnectionShared {
  const Router& router;
  const ServerLimits& limits;
  const std::atomic<bool>& stopping;
  ServerLog& log;
};

/// One client's connection: reads requests and answers them in turn, until either side ends it. All
/// functions but the constructor run on the socket's thread.
class Connection {
 public:
  Connection(Socket socket, std::string address, const ConnectionShared& shared);
  ~Connection();

  /// Until the connection ends. Where `refusal` is given, that is the only answer, and no request
  /// is read.
  Awaitable<void> run(std::unique_ptr<Response> refusal);

  /// The server stops: closes the connection if it waits for a request.
  void stop();

  /// Closes it whatever it does.
  void abort();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace isosplat
