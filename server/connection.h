#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>

#include "server/connection_shared.h"
#include "server/http/message.h"
#include "server/limits/admission.h"
#include "server/net/asio.h"
#include "server/net/tls.h"

namespace isosplat::server {

/// A client's connection: reads requests and sends the responses in the same order, until either
/// side closes it. All functions except the constructor run on the socket's thread.
class Connection {
 public:
  /// `tls`: null for a connection without TLS. The connection reports its state to `slot`, which
  /// must outlive it.
  Connection(Socket socket, std::shared_ptr<TlsContext> tls, const ConnectionShared& shared,
             OpenConnection& slot);
  ~Connection();

  /// Whether the connection comes from a proxy that sends a header of the PROXY protocol. If so,
  /// call read_proxy_header() before run().
  bool has_proxy_header() const;

  /// Reads the header, and counts the connection for the client that it names. Returns that
  /// client's address (IpAddress::client_key), or the address of the proxy if the header names no
  /// client; no value if the connection must be closed.
  Awaitable<std::optional<std::string>> read_proxy_header();

  /// Serves the connection until it ends. If `refusal` is not null, sends only this response and
  /// reads no request.
  Awaitable<void> run(std::unique_ptr<Response> refusal);

  /// Ends the connection if it waits for a request. Called when the server stops.
  void stop();

  /// Closes the connection at once, with a reset if the client has not received everything.
  void abort();

  /// Closes the connection at once, unless its state has changed since it was chosen. Returns
  /// whether it was closed.
  bool close_for_another(OpenConnection::State chosen);

  /// Measures the client's receive rate, and closes the connection if the client has exceeded a
  /// time limit of ServerLimits. Call it regularly: setting a timer for each wait would cost more.
  void watch(std::chrono::steady_clock::time_point now);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace isosplat::server
