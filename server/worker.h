#pragma once

#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <memory>
#include <string>
#include <unordered_set>

#include "server/admission.h"
#include "server/asio.h"
#include "server/connection.h"
#include "server/waiting_connections.h"

namespace isosplat {

/// The event loop of a thread, and the connections of this thread.
class Worker {
 public:
  /// Both arguments must outlive the worker.
  Worker(const ConnectionShared& shared, Admission& admission);

  /// The io_context for the sockets that are passed to adopt().
  boost::asio::io_context& context() { return context_; }

  /// Serves a connection until it ends, with TLS unless `tls` is null. Thread-safe.
  void adopt(Socket socket, std::string address, Admission::Verdict verdict,
             std::shared_ptr<TlsContext> tls);

  /// Since when the connection waits for a request that has waited longest, as
  /// WaitingConnections::longest_since(). Thread-safe.
  int64_t longest_waiting_since() const { return waiting_.longest_since(); }

  /// Closes this connection. Thread-safe. May find that none waits any more.
  void close_longest_waiting();

  /// Closes the connections that wait for a request, and all others after this time.
  /// Thread-safe. Set `shared.stopping` before.
  void stop(std::chrono::milliseconds time);

  /// Closes all connections at once. Thread-safe. Call after stop().
  void abort();

  /// Runs the event loop on the calling thread. Returns after stop(), when the last connection has
  /// ended.
  void run() { context_.run(); }

 private:
  struct Membership;

  Awaitable<void> serve(Socket socket, std::string address, Admission::Verdict verdict,
                        std::shared_ptr<TlsContext> tls);
  void abort_all();
  void finish_if_done();

  /// Closes connections whose time is over, regularly while there are any.
  void watch_deadlines();

  const ConnectionShared& shared_;
  Admission& admission_;
  std::unordered_set<Connection*> connections_;
  WaitingConnections waiting_;
  boost::asio::io_context context_{1};
  boost::asio::executor_work_guard<Executor> guard_;
  Timer deadline_{context_.get_executor()};  ///< of stop()
  Timer watch_{context_.get_executor()};     ///< of watch_deadlines()
  const std::chrono::milliseconds watch_interval_;
};

}  // namespace isosplat
