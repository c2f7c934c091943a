#pragma once

#include <boost/asio/associated_executor.hpp>
#include <boost/asio/async_result.hpp>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/thread_pool.hpp>
#include <cstdint>
#include <exception>
#include <utility>

#include "server/asio.h"
#include "server/metrics.h"

namespace isosplat {

/// Threads that may wait for disks. Connections give them the reads whose bytes are not in memory,
/// so that a slow disk delays only who needs it. At most one task of each connection is queued.
class DiskPool {
 public:
  /// `metrics` must outlive the pool.
  DiskPool(uint32_t threads, Metrics& metrics) : metrics_(metrics), threads_(threads) {}

  /// Runs `task` on a thread of the pool. The coroutine continues on its own thread when the task
  /// has returned; exceptions of the task are thrown there. `task` and what it refers to must
  /// outlive the coroutine's wait, which nothing cancels.
  template <class Task>
  Awaitable<void> run(Task& task) {
    std::exception_ptr thrown;
    ++metrics_.reads_of_disk;
    ++metrics_.reads_waiting;
    co_await boost::asio::async_initiate<const boost::asio::use_awaitable_t<Executor>&, void()>(
        [&](auto handler) {
          // The work guard keeps the connection's event loop running for the handler.
          auto home = boost::asio::make_work_guard(boost::asio::get_associated_executor(handler));
          boost::asio::post(threads_, [&task, &thrown, home = std::move(home),
                                       handler = std::move(handler)]() mutable {
            try {
              task();
            } catch (...) {
              thrown = std::current_exception();
            }
            boost::asio::post(home.get_executor(), std::move(handler));
          });
        },
        boost::asio::use_awaitable_t<Executor>{});
    --metrics_.reads_waiting;
    if (thrown) std::rethrow_exception(thrown);
  }

  /// Waits until the threads have ended. Before the event loops are destroyed: a thread that has
  /// given a coroutine back may still be about to leave its loop.
  void join() { threads_.join(); }

 private:
  Metrics& metrics_;
  boost::asio::thread_pool threads_;
};

}  // namespace isosplat
