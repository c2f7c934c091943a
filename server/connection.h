#pragma once

#include <atomic>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <functional>
#include <memory>
#include <string_view>

#include "server/message.h"
#include "server/router.h"
#include "server/server.h"

namespace isosplat {

using Executor = boost::asio::io_context::executor_type;
using Socket = boost::asio::basic_stream_socket<boost::asio::ip::tcp, Executor>;

/// What every connection of a server shares. Outlives them.
struct ConnectionShared {
  const Router& router;
  const ServerLimits& limits;
  const std::atomic<bool>& stopping;
  std::function<void(std::string_view)> log;         ///< may be empty
  std::function<void(std::string_view)> access_log;  ///< may be empty
};

/// One client's connection: reads requests and answers them in turn, until either side ends it. All
/// functions but the constructor run on the socket's thread.
class Connection {
 public:
  Connection(Socket socket, std::string address, const ConnectionShared& shared);
  ~Connection();

  /// Until the connection ends. Where `refusal` is given, that is the only answer, and no request
  /// is read.
  boost::asio::awaitable<void, Executor> run(std::unique_ptr<Response> refusal);

  /// The server stops: closes the connection if it waits for a request.
  void stop();

  /// Closes it whatever it does.
  void abort();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace isosplat
