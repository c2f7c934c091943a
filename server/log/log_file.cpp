#include "server/log/log_file.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <condition_variable>
#include <mutex>
#include <string>
#include <utility>

#include "shared/system/posix_file/posix_file.h"

namespace isosplat::server {
namespace {

constexpr const char* kStandardOutput = "-";

Result<int> open_to_append(const std::filesystem::path& path) {
  if (path == kStandardOutput) return STDOUT_FILENO;
  // With O_NONBLOCK, opening or writing a pipe without a reader fails instead of waiting.
  const int file =
      ::open(path.c_str(), O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC | O_NOCTTY | O_NONBLOCK, 0640);
  if (file < 0) return file_error(errno, path.string(), "opened");
  return file;
}

std::shared_ptr<const int> shared_descriptor(int descriptor) {
  return {new int(descriptor), [](const int* owned) {
            if (*owned > STDERR_FILENO) ::close(*owned);
            delete owned;
          }};
}

/// While it exists, blocks all signals for the calling thread and for the threads that it starts. A
/// write to a pipe without a reader then fails, and does not end the program (SIGPIPE).
class BlockedSignals {
 public:
  BlockedSignals() {
    sigset_t all;
    ::sigfillset(&all);
    ::pthread_sigmask(SIG_BLOCK, &all, &before_);
  }
  ~BlockedSignals() { ::pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  BlockedSignals(const BlockedSignals&) = delete;
  BlockedSignals& operator=(const BlockedSignals&) = delete;

 private:
  sigset_t before_{};
};

}  // namespace

struct LogFile::State {
  std::mutex mutex;
  std::condition_variable changed;
  std::string waiting;              // guarded by mutex
  uint64_t dropped = 0;             // guarded by mutex
  std::shared_ptr<const int> file;  // guarded by mutex; the last owner closes the descriptor
  bool is_closing = false;          // guarded by mutex
  bool has_ended = false;           // guarded by mutex
  std::atomic<bool> is_abandoned{false};
  bool is_within_line = false;  ///< for the writer: the last write ended within a line

  /// Writes the lines; returns the number of lines that were not written completely.
  uint64_t write(int descriptor, std::string_view lines);
  void write_until_closed();
};

uint64_t LogFile::State::write(int descriptor, std::string_view lines) {
  if (is_within_line) {
    std::string begun = "\n";
    begun += lines;
    is_within_line = false;
    const uint64_t unwritten = write(descriptor, begun);
    return std::min<uint64_t>(unwritten, static_cast<uint64_t>(std::ranges::count(lines, '\n')));
  }
  std::string_view rest = lines;
  while (!rest.empty() && !is_abandoned) {
    const ssize_t count = ::write(descriptor, rest.data(), rest.size());
    if (count > 0) {
      rest.remove_prefix(static_cast<size_t>(count));
    } else if (count < 0 && errno == EAGAIN) {
      pollfd ready{descriptor, POLLOUT, 0};
      ::poll(&ready, 1, 50);
      if (ready.revents & (POLLERR | POLLNVAL)) break;  // there is no reader any more
    } else if (count == 0 || errno != EINTR) {
      break;
    }
  }
  is_within_line = rest.size() < lines.size() && lines[lines.size() - rest.size() - 1] != '\n';
  return static_cast<uint64_t>(std::ranges::count(rest, '\n'));
}

void LogFile::State::write_until_closed() {
  std::unique_lock lock(mutex);
  while (true) {
    changed.wait(lock, [this] { return is_closing || !waiting.empty(); });
    if (waiting.empty() || is_abandoned) break;
    const std::string lines = std::exchange(waiting, {});
    const std::shared_ptr<const int> descriptor = file;
    lock.unlock();
    uint64_t unwritten = 0;
    try {
      unwritten = write(*descriptor, lines);
    } catch (const std::bad_alloc&) {
      unwritten = static_cast<uint64_t>(std::ranges::count(lines, '\n'));
    }
    lock.lock();
    dropped += unwritten;
  }
  has_ended = true;
  changed.notify_all();
}

Result<std::unique_ptr<LogFile>> LogFile::open(const std::filesystem::path& path) {
  const Result<int> file = open_to_append(path);
  if (!file) return tl::unexpected(file.error());
  return std::unique_ptr<LogFile>(new LogFile(path, *file));
}

std::unique_ptr<LogFile> LogFile::standard_output() {
  return std::unique_ptr<LogFile>(new LogFile({}, STDOUT_FILENO));
}

std::unique_ptr<LogFile> LogFile::standard_error() {
  return std::unique_ptr<LogFile>(new LogFile({}, STDERR_FILENO));
}

LogFile::LogFile(std::filesystem::path path, int descriptor)
    : path_(std::move(path)), state_(std::make_shared<State>()) {
  state_->file = shared_descriptor(descriptor);
  const BlockedSignals blocked;
  writer_ = std::thread([state = state_] { state->write_until_closed(); });
}

LogFile::~LogFile() {
  {
    std::unique_lock lock(state_->mutex);
    state_->is_closing = true;
    state_->changed.notify_all();
    state_->is_abandoned =
        !state_->changed.wait_for(lock, kClosingTime, [this] { return state_->has_ended; });
  }
  // A write that the system does not complete must not keep the program from ending.
  state_->is_abandoned ? writer_.detach() : writer_.join();
}

void LogFile::add(std::string_view line) {
  const std::lock_guard lock(state_->mutex);
  if (state_->waiting.size() + line.size() >= kMaxBytes) {
    ++state_->dropped;
    return;
  }
  const bool was_empty = state_->waiting.empty();
  const size_t before = state_->waiting.size();
  try {
    (state_->waiting += line) += '\n';
  } catch (const std::bad_alloc&) {
    state_->waiting.resize(before);
    ++state_->dropped;
    return;
  }
  if (was_empty) state_->changed.notify_all();
}

Result<void> LogFile::reopen() {
  if (path_.empty()) return {};
  const Result<int> file = open_to_append(path_);
  if (!file) return tl::unexpected(file.error());
  auto replacement = shared_descriptor(*file);
  const std::lock_guard lock(state_->mutex);
  state_->file.swap(replacement);
  return {};
}

uint64_t LogFile::dropped() const {
  const std::lock_guard lock(state_->mutex);
  return state_->dropped;
}

}  // namespace isosplat::server
