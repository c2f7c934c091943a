#include "server/limits/work_pool.h"

#include <boost/asio/associated_executor.hpp>
#include <boost/asio/async_result.hpp>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/post.hpp>
#include <chrono>
#include <new>

namespace isosplat::server {

WorkPool::WorkPool(Limits limits, Counters counters) : limits_(limits), counters_(counters) {
  for (uint32_t i = 0; i < limits_.threads; ++i) {
    threads_.emplace_back([this] { work(); });
  }
}

void WorkPool::join() {
  {
    const std::lock_guard lock(mutex_);
    is_ending_ = true;
  }
  changed_.notify_all();
  for (std::thread& thread : threads_) thread.join();
  threads_.clear();
}

Awaitable<WorkPool::Outcome> WorkPool::run(Job& job) {
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

/// Returns whether the job may wait. Sets `displaced` to a job that must be refused instead, if
/// there is one. The caller must hold mutex_.
bool WorkPool::admit(Job& job, Job*& displaced) {
  if (job.kind_ == Kind::continued || running_ + queue_.size() < limits_.threads) return true;
  const uint64_t own = queue_.size_of(job.client_);
  if (own >= uint64_t{limits_.waiting_of_one} * limits_.threads) return false;
  if (queue_.size() < uint64_t{limits_.waiting} * limits_.threads) return true;
  if (queue_.size() == 0) return false;
  const auto& most = queue_.most_of_one();
  if (most.size() <= own + 1 || most.back()->kind_ == Kind::continued) return false;
  displaced = most.back();
  return true;
}

void WorkPool::enter(Job& job) {
  Job* displaced = nullptr;
  bool is_admitted = false;
  try {
    const std::lock_guard lock(mutex_);
    is_admitted = admit(job, displaced);
    if (is_admitted) {
      queue_.push(job.client_, &job);
      ++counters_.waiting;
    }
    if (displaced) queue_.remove(displaced->client_, displaced);
  } catch (const std::bad_alloc&) {
    // Rethrown in the coroutine.
    job.thrown_ = std::current_exception();
    displaced = nullptr;
  }
  if (displaced) {
    --counters_.waiting;
    finish(*displaced, Outcome::refused);
  }
  if (is_admitted) {
    changed_.notify_one();
  } else {
    finish(job, Outcome::refused);
  }
}

void WorkPool::withdraw(Job& job) {
  {
    const std::lock_guard lock(mutex_);
    if (!queue_.remove(job.client_, &job)) return;
  }
  --counters_.waiting;
  finish(job, Outcome::withdrawn);
}

void WorkPool::work() {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return is_ending_ || queue_.size() > 0; });
    if (queue_.size() == 0) return;
    run_next(lock);
  }
}

void WorkPool::run_next(std::unique_lock<std::mutex>& lock) {
  using Clock = std::chrono::steady_clock;
  Job& job = *queue_.pop();
  ++running_;
  lock.unlock();
  const Clock::time_point begin = Clock::now();
  Outcome outcome = Outcome::stopped;
  if (!is_stopped_) {
    ++counters_.started;
    outcome = Outcome::done;
    try {
      job.task_();
    } catch (...) {
      job.thrown_ = std::current_exception();
    }
  }
  const auto time = std::chrono::ceil<std::chrono::microseconds>(Clock::now() - begin);
  lock.lock();
  --running_;
  queue_.charge(job.client_, static_cast<uint64_t>(time.count()));
  lock.unlock();
  --counters_.waiting;
  finish(job, outcome);
  lock.lock();
}

void WorkPool::finish(Job& job, Outcome outcome) {
  job.outcome_ = outcome;
  const std::function<void()> resume = std::move(job.resume_);
  while (true) {
    try {
      return resume();
    } catch (const std::bad_alloc&) {
      // The coroutine must continue. Wait until other threads have freed memory.
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }
}

}  // namespace isosplat::server
