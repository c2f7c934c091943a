#pragma once

#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <string>
#include <unordered_set>

#include "server/admission.h"
#include "server/asio.h"
#include "server/connection.h"

namespace isosplat {

/// A thread, and the connections that live on it.
class Worker {
 public:
  /// Both outlive it.
  Worker(const ConnectionShared& shared, Admission& admission);

  /// For the sockets that it will adopt.
  boost::asio::io_context& context() { return context_; }

  /// Serves a connection until it ends. On any thread.
  void adopt(Socket socket, std::string address, Admission::Verdict verdict);

  /// Ends the connections that wait for a request, and in ServerLimits::stop_time all others. On
  /// any thread, after `shared.stopping` was set.
  void stop();

  /// Ends all connections at once. On any thread, after stop().
  void abort();

  /// The thread itself. Returns after stop(), when the last connection has ended.
  void run() { context_.run(); }

 private:
  struct Membership;

  Awaitable<void> serve(Socket socket, std::string address, Admission::Verdict verdict);
  void abort_all();
  void finish_if_done();

  const ConnectionShared& shared_;
  Admission& admission_;
  std::unordered_set<Connection*> connections_;
  boost::asio::io_context context_{1};
  boost::asio::executor_work_guard<Executor> guard_;
  Timer deadline_{context_.get_executor()};
};

}  // namespace isosplat
