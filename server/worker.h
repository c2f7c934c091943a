#pragma once

#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <cstdint>
#include <memory>
#include <string>
#include <unordered_map>

#include "server/connection.h"
#include "server/limits/admission.h"
#include "server/net/asio.h"

namespace isosplat::server {

/// The event loop of a thread, and the connections of this thread.
class Worker {
 public:
  /// `shared` must outlive the worker.
  explicit Worker(const ConnectionShared& shared);

  /// The io_context for the sockets that are passed to adopt().
  boost::asio::io_context& context() { return context_; }

  /// Serves a connection until it ends, with TLS unless `tls` is null. Thread-safe.
  void adopt(Socket socket, std::unique_ptr<OpenConnection> slot, std::shared_ptr<TlsContext> tls);

  /// Closes connections that wait for a request now, and all others after this time. Thread-safe.
  /// Set `shared.stopping` before.
  void stop(std::chrono::milliseconds time);

  /// Closes all connections at once. Thread-safe. Call after stop().
  void abort();

  /// Runs the event loop on the calling thread. Returns after stop(), once the last connection has
  /// ended. A lack of memory ends only the affected connection.
  void run();

 private:
  struct Membership;

  Awaitable<void> serve(Socket socket, std::unique_ptr<OpenConnection> slot,
                        std::shared_ptr<TlsContext> tls);
  void close_for_another(uint64_t connection, OpenConnection::State chosen);
  void abort_all();
  void finish_if_done();

  /// Closes connections that have exceeded a time limit; checks regularly while there are
  /// connections.
  void watch_deadlines();

  const ConnectionShared& shared_;
  std::unordered_map<uint64_t, Connection*> connections_;  ///< by OpenConnection::id()
  boost::asio::io_context context_{1};
  boost::asio::executor_work_guard<Executor> guard_;
  Timer deadline_{context_.get_executor()};  ///< of stop()
  Timer watch_{context_.get_executor()};     ///< of watch_deadlines()
  const std::chrono::milliseconds watch_interval_;
};

}  // namespace isosplat::server
