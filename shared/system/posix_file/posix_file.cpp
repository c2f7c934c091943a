#include "shared/system/posix_file/posix_file.h"

#include <fcntl.h>
#include <linux/magic.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <system_error>
#include <utility>

namespace isosplat {
namespace {

const char* kind_of(mode_t mode) {
  if (S_ISDIR(mode)) return "a folder";
  return S_ISFIFO(mode) ? "a pipe" : "a device or socket";
}

Result<FileIdentity> identity_of(const struct stat& status, const std::string& name) {
  if (!S_ISREG(status.st_mode)) {
    return fail(Status::io_error, name + ": expected a file, found " + kind_of(status.st_mode));
  }
  return FileIdentity{
      static_cast<uint64_t>(status.st_dev), static_cast<uint64_t>(status.st_ino),
      static_cast<uint64_t>(status.st_size),
      static_cast<int64_t>(status.st_mtim.tv_sec) * 1'000'000'000 + status.st_mtim.tv_nsec};
}

tl::unexpected<Error> needs_disk(NoWait& no_wait, const std::string& name) {
  no_wait.needs_disk = true;
  return fail(Status::io_error, name + ": cannot be read without waiting for the disk");
}

}  // namespace

tl::unexpected<Error> file_error(int number, const std::string& name, const char* action) {
  std::string message = name + ": cannot be " + action + ": ";
  message += std::generic_category().message(number);
  if (number == ENOSPC || number == EDQUOT || number == EFBIG) {
    message += ": free some space, or choose another folder";
  }
  return fail(Status::io_error, std::move(message));
}

Result<FileIdentity> file_identity(const std::filesystem::path& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) return file_error(errno, path.string(), "opened");
  return identity_of(status, path.string());
}

Result<PosixFile> PosixFile::open(const std::filesystem::path& path) {
  // O_NONBLOCK: the opening of a pipe must not wait for its other end.
  PosixFile file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK), path.string());
  if (!file.is_open()) return file_error(errno, file.name_, "opened");
  if (const auto identity = file.identity(); !identity) return tl::unexpected(identity.error());
  file.waits_ = waits_of(file.descriptor_);
  return file;
}

Result<PosixFile> PosixFile::create_temporary(const std::filesystem::path& folder) {
  std::string path = (folder / ".isosplat-spool-XXXXXX").string();
  PosixFile file(::mkostemp(path.data(), O_CLOEXEC), "a temporary file in " + folder.string());
  if (!file.is_open()) return file_error(errno, file.name_, "created");
  ::unlink(path.c_str());
  return file;
}

PosixFile::PosixFile(int descriptor, std::string name)
    : name_(std::move(name)), descriptor_(descriptor) {}

PosixFile::Waits PosixFile::waits_of(int descriptor) {
  char byte = 0;
  const iovec to{&byte, 1};
  if (::preadv2(descriptor, &to, 1, 0, RWF_NOWAIT) >= 0 || errno == EAGAIN) return Waits::reported;
  struct statfs system {};
  const bool is_in_memory = ::fstatfs(descriptor, &system) == 0 &&
                            (system.f_type == TMPFS_MAGIC || system.f_type == RAMFS_MAGIC);
  return is_in_memory ? Waits::never : Waits::unknown;
}

PosixFile::PosixFile(PosixFile&& other) noexcept
    : name_(std::move(other.name_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      waits_(other.waits_) {}

PosixFile& PosixFile::operator=(PosixFile&& other) noexcept {
  std::swap(name_, other.name_);
  std::swap(descriptor_, other.descriptor_);
  std::swap(waits_, other.waits_);
  return *this;
}

PosixFile::~PosixFile() {
  close();
}

void PosixFile::close() {
  if (is_open()) ::close(std::exchange(descriptor_, -1));
}

Result<FileIdentity> PosixFile::identity(NoWait* no_wait) const {
  if (no_wait && waits_ == Waits::unknown) return needs_disk(*no_wait, name_);
  struct stat status {};
  if (::fstat(descriptor_, &status) != 0) return file_error(errno, name_, "read");
  return identity_of(status, name_);
}

Result<size_t> PosixFile::read_some(uint64_t offset, std::span<std::byte> out,
                                    NoWait* no_wait) const {
  if (no_wait && waits_ == Waits::unknown) return needs_disk(*no_wait, name_);
  const int flags = no_wait && waits_ == Waits::reported ? RWF_NOWAIT : 0;
  size_t done = 0;
  while (done < out.size()) {
    const iovec to{out.data() + done, out.size() - done};
    const ssize_t count = ::preadv2(descriptor_, &to, 1, static_cast<off_t>(offset + done), flags);
    if (count < 0 && errno == EINTR) continue;
    // EOPNOTSUPP: the file system cannot determine whether this part of the file is in memory (for
    // example, because it is inline or encrypted).
    if (count < 0 && flags != 0 && (errno == EAGAIN || errno == EOPNOTSUPP)) {
      return needs_disk(*no_wait, name_);
    }
    if (count < 0) return file_error(errno, name_, "read");
    if (count == 0) break;
    done += static_cast<size_t>(count);
  }
  return done;
}

Result<void> PosixFile::read(uint64_t offset, std::span<std::byte> out, NoWait* no_wait) const {
  const Result<size_t> count = read_some(offset, out, no_wait);
  if (!count) return tl::unexpected(count.error());
  if (*count == out.size()) return {};
  return fail(Status::truncated, name_ + ": expected " + std::to_string(out.size()) +
                                     " bytes at offset " + std::to_string(offset) + ", found " +
                                     std::to_string(*count) +
                                     " and the end of the file: copy it again, or make it anew");
}

Result<void> PosixFile::write(uint64_t offset, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t count =
        ::pwrite(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return file_error(errno, name_, "written");
    bytes = bytes.subspan(static_cast<size_t>(count));
    offset += static_cast<uint64_t>(count);
  }
  return {};
}

Result<void> PosixFile::synchronize() {
  if (::fsync(descriptor_) != 0) return file_error(errno, name_, "written");
  return {};
}

}  // namespace isosplat
