#include "native/files/output_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <utility>

#include "native/files/file_io.h"

namespace isosplat {
namespace {

constexpr size_t kBufferBytes = 4 << 20;

std::string temporary_prefix(const std::filesystem::path& target) {
  std::string prefix = target.filename().string();
  prefix.insert(prefix.begin(), '.');
  return prefix.append(".building-");
}

std::filesystem::path folder_of(const std::filesystem::path& target) {
  return target.has_parent_path() ? target.parent_path() : std::filesystem::path(".");
}

/// Removes temporaries of this target whose builds are dead: a live one holds a lock.
void remove_stale(const std::filesystem::path& target) {
  std::error_code ignored;
  const std::string prefix = temporary_prefix(target);
  for (const auto& entry : std::filesystem::directory_iterator(folder_of(target), ignored)) {
    if (!entry.path().filename().string().starts_with(prefix)) continue;
    const int file = ::open(entry.path().c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW);
    if (file < 0) continue;
    if (::flock(file, LOCK_EX | LOCK_NB) == 0) ::unlink(entry.path().c_str());
    ::close(file);
  }
}

/// Names of temporaries, where a signal handler finds them: it may neither lock nor allocate. A
/// program that writes more files at a time leaves the others to remove_stale().
std::array<std::atomic<const char*>, 8> unfinished{};

void replace_unfinished(const char* from, const char* to) {
  for (auto& name : unfinished) {
    const char* expected = from;
    if (name.compare_exchange_strong(expected, to)) return;
  }
}

}  // namespace

void remove_unfinished_files() {
  for (const auto& name : unfinished) {
    if (const char* path = name.load()) ::unlink(path);
  }
}

Result<OutputFile> OutputFile::create(const std::filesystem::path& target) {
  std::error_code ignored;
  const auto status = std::filesystem::status(target, ignored);
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) {
    return fail(Status::invalid_argument,
                target.string() + ": expected the name of a file, found a folder or a device");
  }
  remove_stale(target);
  OutputFile output;
  output.target_ = target;
  // Between its creation and its lock another build may take the temporary for a stale one.
  for (int attempt = 0; attempt < 8; ++attempt) {
    std::string name = (folder_of(target) / (temporary_prefix(target) + "XXXXXX")).string();
    output.file_ = ::mkostemp(name.data(), O_CLOEXEC);
    if (output.file_ < 0) return system_error("create a file in", folder_of(target));
    struct stat found {};
    if (::flock(output.file_, LOCK_EX | LOCK_NB) == 0 && ::stat(name.c_str(), &found) == 0) {
      output.temporary_ = std::make_unique<const std::filesystem::path>(name);
      replace_unfinished(nullptr, output.temporary_->c_str());
      break;
    }
    ::close(std::exchange(output.file_, -1));
  }
  if (output.file_ < 0) return system_error("lock a file in", folder_of(target));
  const mode_t mask = ::umask(0);
  ::umask(mask);
  ::fchmod(output.file_, 0666 & ~mask);
  output.pending_.reserve(kBufferBytes);
  return output;
}

OutputFile::OutputFile(OutputFile&& other) noexcept
    : target_(std::move(other.target_)),
      temporary_(std::move(other.temporary_)),
      file_(std::exchange(other.file_, -1)),
      pending_(std::move(other.pending_)),
      pending_offset_(other.pending_offset_) {}

OutputFile::~OutputFile() {
  if (file_ >= 0) ::close(file_);
  if (!temporary_) return;
  ::unlink(temporary_->c_str());
  replace_unfinished(temporary_->c_str(), nullptr);
}

Result<void> OutputFile::flush() {
  auto written = write_fully(file_, pending_offset_, pending_, target_);
  pending_.clear();
  return written;
}

Result<void> OutputFile::write(uint64_t offset, std::span<const std::byte> bytes) {
  if (!pending_.empty() && (offset != pending_offset_ + pending_.size() ||
                            pending_.size() + bytes.size() > kBufferBytes)) {
    if (auto flushed = flush(); !flushed) return flushed;
  }
  if (bytes.size() > kBufferBytes) return write_fully(file_, offset, bytes, target_);
  if (pending_.empty()) pending_offset_ = offset;
  pending_.insert(pending_.end(), bytes.begin(), bytes.end());
  return {};
}

Result<void> OutputFile::publish() {
  if (auto flushed = flush(); !flushed) return flushed;
  if (::fsync(file_) != 0) return system_error("write", target_);
  if (::rename(temporary_->c_str(), target_.c_str()) != 0) {
    return system_error("rename a finished store to", target_);
  }
  replace_unfinished(temporary_->c_str(), nullptr);
  temporary_.reset();
  const int folder = ::open(folder_of(target_).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder >= 0) {
    ::fsync(folder);  // not every file system can; the store is whole either way
    ::close(folder);
  }
  return {};
}

}  // namespace isosplat
