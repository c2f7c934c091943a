#pragma once

#include <atomic>
#include <boost/asio/associated_executor.hpp>
#include <boost/asio/async_result.hpp>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/thread_pool.hpp>
#include <cstdint>
#include <exception>
#include <utility>

#include "server/asio.h"

namespace isosplat {

/// Threads for what would hold up a connection's thread, which serves other connections as well:
/// reads that wait for disks, and computations. Only the request that needs the work waits. At most
/// one task of each connection is queued.
class WorkPool {
 public:
  /// Counts its tasks: `started` so far, `waiting` those that are queued or run now. Both must
  /// outlive the pool.
  WorkPool(uint32_t threads, std::atomic<uint64_t>& started, std::atomic<uint64_t>& waiting)
      : started_(started), waiting_(waiting), size_(threads), threads_(threads) {}

  /// Runs `task` on a thread of the pool. The coroutine continues on its own thread when the task
  /// has returned; exceptions of the task are thrown there. `task` and what it refers to must
  /// outlive the coroutine's wait. Returns false, and does not run the task, if stop() was called
  /// before its turn.
  template <class Task>
  Awaitable<bool> run(Task& task) {
    std::exception_ptr thrown;
    bool has_run = false;
    ++started_;
    ++waiting_;
    co_await boost::asio::async_initiate<const boost::asio::use_awaitable_t<Executor>&, void()>(
        [&](auto handler) {
          // The work guard keeps the connection's event loop running for the handler.
          auto home = boost::asio::make_work_guard(boost::asio::get_associated_executor(handler));
          boost::asio::post(threads_, [this, &task, &thrown, &has_run, home = std::move(home),
                                       handler = std::move(handler)]() mutable {
            try {
              has_run = !is_stopped_;
              if (has_run) task();
            } catch (...) {
              thrown = std::current_exception();
            }
            boost::asio::post(home.get_executor(), std::move(handler));
          });
        },
        boost::asio::use_awaitable_t<Executor>{});
    --waiting_;
    if (thrown) std::rethrow_exception(thrown);
    co_return has_run;
  }

  /// Whether fewer than `most` tasks per thread wait for a thread.
  bool has_room(uint32_t most) const { return waiting_ < uint64_t{size_} * (1 + uint64_t{most}); }

  /// Tasks whose turn has not come are not run any more. Thread-safe.
  void stop() { is_stopped_ = true; }

  /// Waits until the threads have ended. Call it before the event loops are destroyed: a thread
  /// that has posted a handler may still be using the loop.
  void join() { threads_.join(); }

 private:
  std::atomic<uint64_t>& started_;
  std::atomic<uint64_t>& waiting_;
  std::atomic<bool> is_stopped_{false};
  const uint32_t size_;
  boost::asio::thread_pool threads_;
};

}  // namespace isosplat
