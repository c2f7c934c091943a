#include "native/build/output_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <utility>

#include "native/build/file_io.h"

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

}  // namespace

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
    output.temporary_ = name;
    struct stat found {};
    if (::flock(output.file_, LOCK_EX | LOCK_NB) == 0 && ::stat(name.c_str(), &found) == 0) break;
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
      temporary_(std::exchange(other.temporary_, {})),
      file_(std::exchange(other.file_, -1)),
      pending_(std::move(other.pending_)),
      pending_offset_(other.pending_offset_) {}

OutputFile::~OutputFile() {
  if (file_ >= 0) ::close(file_);
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
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
  if (::rename(temporary_.c_str(), target_.c_str()) != 0) {
    return system_error("rename a finished store to", target_);
  }
  temporary_.clear();
  const int folder = ::open(folder_of(target_).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder >= 0) {
    ::fsync(folder);  // not every file system can; the store is whole either way
    ::close(folder);
  }
  return {};
}

}  // namespace isosplat
