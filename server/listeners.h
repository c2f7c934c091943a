#pragma once

#include <boost/asio/io_context.hpp>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "server/connection_shared.h"
#include "server/limits/admission.h"
#include "server/net/asio.h"
#include "server/net/hand_over.h"
#include "server/server.h"
#include "server/tls_loader.h"
#include "server/worker.h"
#include "shared/core/base/status.h"

namespace isosplat::server {

/// The listening sockets of a server. Distributes admitted connections to the workers in turn. For
/// the thread of `control`, except as stated.
class Listeners {
 public:
  using Workers = std::vector<std::unique_ptr<Worker>>;

  /// All must outlive it.
  Listeners(boost::asio::io_context& control, const ConnectionShared& shared, Admission& admission,
            TlsLoader& tls, const Workers& workers)
      : control_(control), shared_(shared), admission_(admission), tls_(tls), workers_(workers) {}

  /// Binds the addresses of the options, or takes over their sockets. Call before start(). Errors:
  /// io_error.
  Result<void> open(const ServerOptions& options);

  /// The port for requests. Thread-safe after open().
  uint16_t port() const { return port_; }

  /// The port that redirects to https; 0: none. Thread-safe until close().
  uint16_t redirecting_port() const;

  /// Whether only this machine can reach the server. Call before close().
  bool is_local() const;

  /// The open sockets, for a new process.
  ListeningSockets sockets();

  /// Starts to accept. Call it before the event loop runs; there must be a worker.
  void start();

  /// Accepts no more.
  void close();

 private:
  Awaitable<void> accept_on(Acceptor& acceptor, bool has_tls);
  void admit(Worker& worker, Socket socket, const boost::asio::ip::tcp::endpoint& peer,
             bool has_tls);

  boost::asio::io_context& control_;
  const ConnectionShared& shared_;
  Admission& admission_;
  TlsLoader& tls_;
  const Workers& workers_;
  size_t next_worker_ = 0;
  uint16_t port_ = 0;
  std::vector<Acceptor> acceptors_;
  std::vector<Acceptor> redirecting_;  ///< to https
};

}  // namespace isosplat::server
