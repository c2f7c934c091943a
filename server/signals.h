#pragma once

#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <chrono>
#include <functional>
#include <optional>
#include <utility>

#include "server/listeners.h"
#include "server/log/server_log.h"
#include "server/net/asio.h"
#include "server/net/hand_over.h"
#include "server/routes/metrics.h"
#include "server/server.h"
#include "shared/core/base/status.h"

namespace isosplat::server {

/// Handles signals of the process (ServerOptions::handle_signals), and the hand-over to a new
/// process. Call its functions on the thread of `control`, except as stated.
class Signals {
 public:
  struct Actions {
    std::function<Result<void>()> reload;
    std::function<void(std::chrono::milliseconds)> stop;  ///< Server::stop(), within this time
    std::function<void(std::chrono::milliseconds)> stop_sooner;  ///< shortens the time of stop()
    std::function<void()> close_connections;
  };

  /// All must outlive it.
  Signals(boost::asio::io_context& control, const ServerLimits& limits, Listeners& listeners,
          ServerLog& log, Metrics& metrics, const std::atomic<bool>& stopping, Actions actions)
      : control_(control),
        limits_(limits),
        listeners_(listeners),
        log_(log),
        metrics_(metrics),
        stopping_(stopping),
        actions_(std::move(actions)) {}

  /// Starts to wait for signals. `has_files`: there are files that a reload reads. Call it before
  /// the event loop runs.
  void start(bool has_files);

  /// Stops waiting for signals.
  void cancel() {
    if (signals_) signals_->cancel();
  }

 private:
  void wait();
  void handle(int signal);
  void hand_over();
  Awaitable<void> await_successor(Successor successor);

  boost::asio::io_context& control_;
  const ServerLimits& limits_;
  Listeners& listeners_;
  ServerLog& log_;
  Metrics& metrics_;
  const std::atomic<bool>& stopping_;
  const Actions actions_;
  std::optional<boost::asio::signal_set> signals_;  ///< absent before start()
  bool has_successor_ = false;                      ///< a new process is starting
  bool is_handed_over_ =
      false;  ///< the sockets are handed over; responses in progress are being completed
};

}  // namespace isosplat::server
