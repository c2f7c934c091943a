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
  /// `tls`: null for a connection without TLS. `place` is told how the connection gets on; it must
  /// outlive it.
  Connection(Socket socket, std::shared_ptr<TlsContext> tls, const ConnectionShared& shared,
             OpenConnection& place);
  ~Connection();

  /// Whether the connection is one of a proxy that sends a header of the PROXY protocol: call
  /// read_proxy_header() before run().
  bool has_proxy_header() const;

  /// Reads the header. The connection is then one of the client that it names. Returns its address
  /// (IpAddress::client_key), or that of the proxy if it names none; no value if the connection
  /// must be closed.
  Awaitable<std::optional<std::string>> read_proxy_header();

  /// Serves the connection until it ends. If `refusal` is not null, sends only this response and
  /// reads no request.
  Awaitable<void> run(std::unique_ptr<Response> refusal);

  /// Ends the connection if it waits for a request. For a server that stops.
  void stop();

  /// Closes the connection at once, with a reset if the client has not taken everything.
  void abort();

  /// Closes the connection at once, unless its state has changed since it was chosen. Returns
  /// whether it did.
  bool close_for_another(OpenConnection::State chosen);

  /// Measures how fast the client takes a response, and closes the connection if it has not done in
  /// time what it must (the times of ServerLimits). Call it regularly: setting a timer for each
  /// wait would cost more.
  void watch(std::chrono::steady_clock::time_point now);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace isosplat::server
