#pragma once

#include <atomic>
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

/// Threads for work that would block a connection's thread, which serves other connections as well:
/// reads that wait for disks, and computations. Only the request that needs the work waits. The
/// threads schedule clients fairly (FairQueue, by the duration of their jobs).
class WorkPool {
 public:
  struct Limits {
    uint32_t threads = 1;
    // The maximum number of waiting jobs per thread. Further ones are refused. If the limit of all
    // clients is reached, a client with fewer jobs displaces the last job of the client with the
    // most.
    uint32_t waiting = UINT32_MAX;
    uint32_t waiting_of_one = UINT32_MAX;  ///< maximum for one client
  };

  /// All must outlive the pool.
  struct Counters {
    std::atomic<uint64_t>& started;  ///< jobs that a thread has begun
    std::atomic<uint64_t>& waiting;  ///< jobs that are queued or running
  };

  enum class Outcome : uint8_t {
    done,
    refused,    ///< too many jobs wait
    withdrawn,  ///< by withdraw()
    stopped     ///< stop() was called before its turn
  };

  enum class Kind : uint8_t {
    first,     ///< the first job of a request: it may be refused
    continued  ///< a further job of a request that was admitted
  };

  /// A task of a client. The coroutine that waits for it in run() owns it.
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
    std::function<void()> resume_;  ///< resumes the coroutine, which may destroy the job
    Outcome outcome_ = Outcome::stopped;
    std::exception_ptr thrown_;
  };

  WorkPool(Limits limits, Counters counters);
  ~WorkPool() { join(); }

  /// Runs the job's task on a thread of the pool. The coroutine continues on its own thread once
  /// the task has returned, or will not run. Exceptions of the task are rethrown there. Throws
  /// bad_alloc.
  Awaitable<Outcome> run(Job& job);

  /// Withdraws a job that has not begun, so that it does not run. Call it on the thread of the
  /// coroutine that waits in run().
  void withdraw(Job& job);

  /// Drops the tasks that have not begun. Thread-safe.
  void stop() { is_stopped_ = true; }

  /// Waits until the threads have ended. Call it before destroying the event loops: a thread that
  /// has resumed a coroutine may still be using the loop.
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
