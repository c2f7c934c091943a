#include "native/files/file_io.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace isosplat {

tl::unexpected<Error> system_error(const char* what, const std::filesystem::path& path) {
  const int number = errno;
  std::string message = std::string("cannot ") + what + " " + path.string() + ": ";
  message += std::strerror(number);
  if (number == ENOSPC || number == EDQUOT || number == EFBIG) {
    message += ": free some space, or build into another folder";
  }
  return fail(Status::io_error, message);
}

Result<void> write_fully(int file, uint64_t offset, std::span<const std::byte> bytes,
                         const std::filesystem::path& path) {
  while (!bytes.empty()) {
    const ssize_t written = ::pwrite(file, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return system_error("write", path);
    bytes = bytes.subspan(static_cast<size_t>(written));
    offset += static_cast<uint64_t>(written);
  }
  return {};
}

Result<void> read_fully(int file, uint64_t offset, std::span<std::byte> bytes,
                        const std::filesystem::path& path) {
  while (!bytes.empty()) {
    const ssize_t count = ::pread(file, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return system_error("read", path);
    if (count == 0) {
      return fail(Status::truncated, path.string() + ": expected " + std::to_string(bytes.size()) +
                                         " more bytes at offset " + std::to_string(offset) +
                                         ", found the file's end");
    }
    bytes = bytes.subspan(static_cast<size_t>(count));
    offset += static_cast<uint64_t>(count);
  }
  return {};
}

}  // namespace isosplat
