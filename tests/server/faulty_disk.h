#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <mutex>

namespace isosplat::server::test {

/// Imitates a slow disk. Reads of files named "slow…" wait here. Reads that must not wait (NoWait)
/// never find the bytes of these files in memory. They do not find the bytes of files named "cold…"
/// either, but other reads of "cold…" do not wait.
class Gate {
 public:
  void close() { close_after(0); }
  /// Closes it after this many reads.
  void close_after(int reads) {
    const std::lock_guard lock(mutex_);
    is_open_ = false;
    allowed_ = reads;
  }
  void open() {
    const std::lock_guard lock(mutex_);
    is_open_ = true;
    changed_.notify_all();
  }
  void pass() {
    std::unique_lock lock(mutex_);
    ++waiting_;
    ++reads_;
    changed_.notify_all();
    if (!is_open_ && allowed_ > 0) {
      --allowed_;
    } else {
      changed_.wait(lock, [this] { return is_open_; });
    }
    --waiting_;
  }
  /// The number of reads so far.
  int reads() {
    const std::lock_guard lock(mutex_);
    return reads_;
  }
  /// Waits until this many reads wait.
  void await(int reads) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return waiting_ >= reads; });
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  bool is_open_ = true;  // guarded by mutex_
  int waiting_ = 0;      // guarded by mutex_
  int reads_ = 0;        // guarded by mutex_
  int allowed_ = 0;      // guarded by mutex_; reads that still pass the closed gate
};

/// The gate of this program.
Gate& gate();

inline constexpr uint64_t kNoBadBytes = UINT64_MAX;

/// The offset of the first byte that cannot be read, in each file with "damaged-disk" in its name.
/// A read that reaches this byte fails with EIO. Initially kNoBadBytes: all bytes can be read.
std::atomic<uint64_t>& first_bad_byte();

}  // namespace isosplat::server::test
