#include "server/log_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <utility>

#include "shared/posix_file/posix_file.h"

namespace isosplat {
namespace {

constexpr const char* kStandardOutput = "-";

Result<int> open_to_append(const std::filesystem::path& path) {
  if (path == kStandardOutput) return STDOUT_FILENO;
  // O_NONBLOCK: opening a pipe without a reader is an error, and does not wait.
  const int file =
      ::open(path.c_str(), O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC | O_NOCTTY | O_NONBLOCK, 0640);
  if (file < 0) return file_error(errno, path.string(), "opened");
  ::fcntl(file, F_SETFL, O_APPEND);  // writing to a pipe may wait
  return file;
}

std::shared_ptr<const int> shared_descriptor(int descriptor) {
  return {new int(descriptor), [](const int* owned) {
            if (*owned != STDOUT_FILENO) ::close(*owned);
            delete owned;
          }};
}

/// The number of lines of `text` that were not written.
uint64_t write_all(int file, std::string_view text) {
  while (!text.empty()) {
    const ssize_t count = ::write(file, text.data(), text.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) break;
    text.remove_prefix(static_cast<size_t>(count));
  }
  return static_cast<uint64_t>(std::ranges::count(text, '\n'));
}

}  // namespace

Result<std::unique_ptr<LogFile>> LogFile::open(const std::filesystem::path& path) {
  const Result<int> file = open_to_append(path);
  if (!file) return tl::unexpected(file.error());
  return std::unique_ptr<LogFile>(new LogFile(path, *file));
}

LogFile::LogFile(std::filesystem::path path, int descriptor)
    : path_(std::move(path)),
      file_(shared_descriptor(descriptor)),
      writer_([this] { write_until_closed(); }) {}

LogFile::~LogFile() {
  {
    const std::lock_guard lock(mutex_);
    is_closing_ = true;
  }
  changed_.notify_all();
  writer_.join();
}

void LogFile::add(std::string_view line) {
  {
    const std::lock_guard lock(mutex_);
    if (waiting_.size() + line.size() >= kMaxBytes) {
      ++lost_;
      return;
    }
    (waiting_ += line) += '\n';
  }
  changed_.notify_all();
}

Result<void> LogFile::reopen() {
  const Result<int> file = open_to_append(path_);
  if (!file) return tl::unexpected(file.error());
  auto replacement = shared_descriptor(*file);
  const std::lock_guard lock(mutex_);
  file_.swap(replacement);
  return {};
}

uint64_t LogFile::lost() const {
  const std::lock_guard lock(mutex_);
  return lost_;
}

void LogFile::write_until_closed() {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return is_closing_ || !waiting_.empty(); });
    if (waiting_.empty()) return;
    const std::string lines = std::exchange(waiting_, {});
    const std::shared_ptr<const int> file = file_;
    lock.unlock();
    const uint64_t unwritten = write_all(*file, lines);
    lock.lock();
    lost_ += unwritten;
  }
}

}  // namespace isosplat
