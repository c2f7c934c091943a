// The linker replaces the preadv2 calls of this program by the function below (--wrap).

#include "tests/server/faulty_disk.h"

#include <sys/uio.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <string_view>

namespace isosplat::server::test {
namespace {

std::string path_of(int descriptor) {
  char target[4096];
  const std::string link = "/proc/self/fd/" + std::to_string(descriptor);
  const ssize_t length = ::readlink(link.c_str(), target, sizeof target);
  return {target, length > 0 ? static_cast<size_t>(length) : 0};
}

uint64_t bytes_of(const iovec* to, int count) {
  uint64_t bytes = 0;
  for (int i = 0; i < count; ++i) bytes += to[i].iov_len;
  return bytes;
}

}  // namespace

Gate& gate() {
  static Gate gate;
  return gate;
}

std::atomic<uint64_t>& first_bad_byte() {
  static std::atomic<uint64_t> byte{kNoBadBytes};
  return byte;
}

}  // namespace isosplat::server::test

extern "C" {
ssize_t __real_preadv2(int descriptor, const iovec* to, int count, off_t offset, int flags);
ssize_t __wrap_preadv2(int descriptor, const iovec* to, int count, off_t offset, int flags);

ssize_t __wrap_preadv2(int descriptor, const iovec* to, int count, off_t offset, int flags) {
  using namespace isosplat::server::test;
  const std::string path = path_of(descriptor);
  const bool is_slow = path.find("/slow") != std::string::npos;
  const bool is_cold = path.find("/cold") != std::string::npos;
  if ((flags & RWF_NOWAIT) && (is_slow || is_cold)) {
    errno = EAGAIN;
    return -1;
  }
  if (is_slow) gate().pass();
  if (path.find("damaged-disk") != std::string::npos &&
      static_cast<uint64_t>(offset) + bytes_of(to, count) > first_bad_byte()) {
    errno = EIO;
    return -1;
  }
  return __real_preadv2(descriptor, to, count, offset, flags);
}
}
