#include "native/files/output_file.h"

#include <fmt/format.h>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <fstream>
#include <optional>
#include <utility>

namespace isosplat {
namespace {

constexpr size_t kBufferBytes = 4 << 20;
constexpr size_t kMaxPrefix = 200;  // file names may have 255 bytes

std::string temporary_prefix(const std::filesystem::path& target) {
  std::string prefix = target.filename().string();
  prefix.insert(prefix.begin(), '.');
  prefix.resize(std::min(prefix.size(), kMaxPrefix));
  return prefix.append(".building-");
}

std::filesystem::path folder_of(const std::filesystem::path& target) {
  return target.has_parent_path() ? target.parent_path() : std::filesystem::path(".");
}

/// The target of a chain of symbolic links, which need not exist. No value for a cycle.
std::optional<std::filesystem::path> end_of_links(std::filesystem::path path) {
  std::error_code error;
  for (int links = 0; links < 40; ++links) {
    if (!std::filesystem::is_symlink(std::filesystem::symlink_status(path, error))) return path;
    const auto next = std::filesystem::read_symlink(path, error);
    if (error) return std::nullopt;
    path = next.is_absolute() ? next : folder_of(path) / next;
  }
  return std::nullopt;
}

const char* kind_of(std::filesystem::file_type type) {
  switch (type) {
    case std::filesystem::file_type::directory:
      return "a folder";
    case std::filesystem::file_type::fifo:
      return "a pipe";
    case std::filesystem::file_type::socket:
      return "a socket";
    default:
      return "a device";
  }
}

/// Removes temporary files of this target that no running program has locked.
void remove_stale(const std::filesystem::path& target) {
  std::error_code ignored;
  const std::string prefix = temporary_prefix(target);
  for (const auto& entry : std::filesystem::directory_iterator(folder_of(target), ignored)) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with(prefix) || name.size() != prefix.size() + 16) continue;
    const int file = ::open(entry.path().c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
    if (file < 0) continue;
    if (::flock(file, LOCK_EX | LOCK_NB) == 0) ::unlink(entry.path().c_str());
    ::close(file);
  }
}

/// Names of temporary files for the signal handler, which may neither lock nor allocate. If a
/// program writes more files at a time, remove_stale() removes the others later.
std::array<std::atomic<const char*>, 8> unfinished{};
std::atomic<pid_t> unfinished_of{0};

void replace_unfinished(const char* from, const char* to) {
  unfinished_of = ::getpid();
  for (auto& name : unfinished) {
    const char* expected = from;
    if (name.compare_exchange_strong(expected, to)) return;
  }
}

std::string unique_suffix() {
  uint64_t number = 0;
  if (::getrandom(&number, sizeof number, 0) != sizeof number) {
    static std::atomic<uint64_t> count{0};
    number = static_cast<uint64_t>(::getpid()) << 32 | ++count;
  }
  return fmt::format("{:016x}", number);
}

}  // namespace

std::string first_bytes(const std::filesystem::path& path, size_t count) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) return {};
  std::string bytes(count, '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(bytes.data(), static_cast<std::streamsize>(count));
  bytes.resize(static_cast<size_t>(file.gcount()));
  return bytes;
}

Result<void> write_whole_file(const std::filesystem::path& target,
                              std::span<const std::byte> bytes) {
  auto file = OutputFile::create(target);
  if (!file) return tl::unexpected(file.error());
  if (auto written = file->write(0, bytes); !written) return written;
  return file->publish();
}

void remove_unfinished_files() {
  if (unfinished_of != ::getpid()) return;
  for (const auto& name : unfinished) {
    if (const char* path = name.load()) ::unlink(path);
  }
}

Result<OutputFile> OutputFile::create(const std::filesystem::path& target) {
  std::error_code ignored;
  const auto status = std::filesystem::status(target, ignored);
  const bool exists = std::filesystem::exists(status);
  if (exists && !std::filesystem::is_regular_file(status)) {
    return fail(Status::invalid_argument,
                fmt::format("{}: expected the name of a file, found {}: give another name",
                            target.string(), kind_of(status.type())));
  }
  const auto end = end_of_links(target);
  if (!end || (exists && !std::filesystem::equivalent(*end, target, ignored))) {
    return fail(Status::io_error,
                fmt::format("{}: expected the name of a file, found a link whose target does not "
                            "exist: remove it, or give another name",
                            target.string()));
  }
  if (exists && ::access(end->c_str(), W_OK) != 0)
    return file_error(errno, target.string(), "replaced");
  remove_stale(*end);
  OutputFile output;
  output.target_ = *end;
  // Another program may remove the temporary file as stale between its creation and its lock. In
  // this case, create another one.
  for (int attempt = 0; attempt < 8 && !output.file_.is_open(); ++attempt) {
    output.temporary_ = std::make_unique<const std::filesystem::path>(
        folder_of(*end) / (temporary_prefix(*end) + unique_suffix()));
    const char* name = output.temporary_->c_str();
    replace_unfinished(nullptr, name);  // before it exists: a signal may arrive at any time
    output.file_ = PosixFile(::open(name, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0666),
                             target.string());
    if (!output.file_.is_open() && errno != EEXIST) {
      const int number = errno;
      replace_unfinished(name, nullptr);
      output.temporary_.reset();
      return file_error(number, target.string(), "created");
    }
    struct stat found {};
    if (output.file_.is_open() && ::flock(output.file_.descriptor(), LOCK_EX | LOCK_NB) == 0 &&
        ::stat(name, &found) == 0) {
      break;
    }
    replace_unfinished(name, nullptr);
    output.file_.close();
  }
  if (!output.file_.is_open()) {
    output.temporary_.reset();
    return file_error(errno, target.string(), "locked");
  }
  if (exists) ::fchmod(output.file_.descriptor(), static_cast<mode_t>(status.permissions()) & 0777);
  output.pending_.reserve(kBufferBytes);
  return output;
}

OutputFile::OutputFile(OutputFile&& other) noexcept
    : target_(std::move(other.target_)),
      temporary_(std::move(other.temporary_)),
      file_(std::move(other.file_)),
      pending_(std::move(other.pending_)),
      pending_offset_(other.pending_offset_) {}

OutputFile::~OutputFile() {
  if (!temporary_) return;
  ::unlink(temporary_->c_str());
  replace_unfinished(temporary_->c_str(), nullptr);
}

Result<void> OutputFile::flush() {
  auto written = file_.write(pending_offset_, pending_);
  pending_.clear();
  return written;
}

Result<void> OutputFile::write(uint64_t offset, std::span<const std::byte> bytes) {
  if (!pending_.empty() && (offset != pending_offset_ + pending_.size() ||
                            pending_.size() + bytes.size() > kBufferBytes)) {
    if (auto flushed = flush(); !flushed) return flushed;
  }
  if (bytes.size() > kBufferBytes) return file_.write(offset, bytes);
  if (pending_.empty()) pending_offset_ = offset;
  pending_.insert(pending_.end(), bytes.begin(), bytes.end());
  return {};
}

Result<void> OutputFile::publish() {
  if (auto flushed = flush(); !flushed) return flushed;
  if (auto synchronized = file_.synchronize(); !synchronized) return synchronized;
  if (::rename(temporary_->c_str(), target_.c_str()) != 0) {
    return file_error(errno, target_.string(), "replaced by the finished file");
  }
  replace_unfinished(temporary_->c_str(), nullptr);
  temporary_.reset();
  const int folder = ::open(folder_of(target_).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder >= 0) {
    ::fsync(folder);  // some file systems do not support it; the file itself is complete
    ::close(folder);
  }
  return {};
}

}  // namespace isosplat
