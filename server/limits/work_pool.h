#pragma once

#include <atomic>
#include <boost/asio/associated_executor.hpp>
#include <boost/asio/async_result.hpp>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/post.hpp>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "server/limits/fair_queue.h"
#include "server/net/asio.h"

namespace isosplat::server {

/// Threads for what would hold up a connection's thread, which serves other connections as well:
/// reads that wait for disks, and computations. Only the request that needs the work waits. The
/// threads serve clients by turns (FairQueue, by the time that their jobs take).
class WorkPool {
 public:
  struct Limits {
    uint32_t threads = 1;
    // Jobs that wait for a thread, for each thread: others are refused. If all together are too
    // many, the client that has most loses its last one to a client that has fewer.
    uint32_t waiting = UINT32_MAX;
    uint32_t waiting_of_one = UINT32_MAX;  ///< of one client
  };

  /// All must outlive the pool.
  struct Counters {
    std::atomic<uint64_t>& started;  ///< that a thread has begun, so far
    std::atomic<uint64_t>& waiting;  ///< that are queued or run now
  };

  enum class Outcome : uint8_t {
    done,
    refused,    ///< too many wait
    withdrawn,  ///< by withdraw()
    stopped     ///< stop() was called before its turn
  };

  enum class Kind : uint8_t {
    first,     ///< of a request: it may be refused
    continued  ///< of a request that was let in
  };

  /// A task of a client. Its owner is the coroutine that waits for it in run().
  class Job {
   public:
    /// `task` must outlive the wait.
    template <class Task>
    Job(std::string client, Kind kind, Task& task)
        : client_(std::move(client)), kind_(kind), task_(std::ref(task)) {}
    Job(const Job&) = delete;
    Job& operator=(const Job&) = delete;

   private:
    friend class WorkPool;
    const std::string client_;
    const Kind kind_;
    const std::function<void()> task_;
    std::function<void()> resume_;  ///< lets the coroutine go on; the job may end then
    Outcome outcome_ = Outcome::stopped;
    std::exception_ptr thrown_;
  };

  WorkPool(Limits limits, Counters counters);
  ~WorkPool() { join(); }

  /// Runs the job's task on a thread of the pool. The coroutine continues on its own thread when it
  /// has returned, or is not to be run; exceptions of the task are thrown there. Throws bad_alloc.
  Awaitable<Outcome> run(Job& job) {
    co_await boost::asio::async_initiate<const boost::asio::use_awaitable_t<Executor>&, void()>(
        [this, &job](auto handler) {
          // The work guard keeps the connection's event loop running for the handler.
          auto home = boost::asio::make_work_guard(boost::asio::get_associated_executor(handler));
          auto shared = std::make_shared<decltype(handler)>(std::move(handler));
          job.resume_ = [home, shared] {
            boost::asio::post(home.get_executor(), [shared] { std::move (*shared)(); });
          };
          enter(job);
        },
        boost::asio::use_awaitable_t<Executor>{});
    if (job.thrown_) std::rethrow_exception(job.thrown_);
    co_return job.outcome_;
  }

  /// A job whose turn has not come is not run any more. Call it on the thread of its coroutine,
  /// which waits in run().
  void withdraw(Job& job);

  /// Tasks whose turn has not come are not run any more. Thread-safe.
  void stop() { is_stopped_ = true; }

  /// Waits until the threads have ended. Call it before the event loops are destroyed: a thread
  /// that has resumed a coroutine may still be using the loop.
  void join();

 private:
  void enter(Job& job);
  bool admit(Job& job, Job*& displaced);
  void work();
  void run_next(std::unique_lock<std::mutex>& lock);
  void finish(Job& job, Outcome outcome);

  const Limits limits_;
  const Counters counters_;
  std::atomic<bool> is_stopped_{false};
  std::mutex mutex_;
  std::condition_variable changed_;
  FairQueue<Job> queue_;    // guarded by mutex_
  uint32_t running_ = 0;    // guarded by mutex_
  bool is_ending_ = false;  // guarded by mutex_
  std::vector<std::thread> threads_;
};

}  // namespace isosplat::server
