#include "shared/import/codecs/isolated.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <utility>

namespace isosplat::import {
namespace {

/// The header of a result in the pipe; the text follows.
struct ResultHeader {
  uint32_t status;  ///< ok: the text is the result; otherwise the error message
  uint32_t complete = kComplete;

  static constexpr uint32_t kComplete = 0x600d600d;
};

bool write_all(int descriptor, const void* data, size_t size) {
  const char* from = static_cast<const char*>(data);
  while (size > 0) {
    const ssize_t done = ::write(descriptor, from, size);
    if (done < 0 && errno == EINTR) continue;
    if (done <= 0) return false;
    from += done;
    size -= static_cast<size_t>(done);
  }
  return true;
}

std::string read_to_end(int descriptor) {
  std::string text;
  std::array<char, 16 * 1024> buffer;
  for (;;) {
    const ssize_t got = ::read(descriptor, buffer.data(), buffer.size());
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return text;
    text.append(buffer.data(), static_cast<size_t>(got));
  }
}

/// Size of the address space that this process has mapped, in bytes.
[[maybe_unused]] uint64_t mapped_bytes() {
  unsigned long long pages = 0;
  if (FILE* statm = std::fopen("/proc/self/statm", "re")) {
    if (std::fscanf(statm, "%llu", &pages) != 1) pages = 0;
    std::fclose(statm);
  }
  return pages * static_cast<uint64_t>(::sysconf(_SC_PAGESIZE));
}

/// Limits memory, so that a damaged length field cannot make a reader allocate all of it.
void limit_memory([[maybe_unused]] uint64_t bytes) {
#ifndef __SANITIZE_ADDRESS__  // its shadow memory exceeds any limit
  const uint64_t allowed = mapped_bytes() + bytes;
  const rlimit memory{allowed, allowed};
  setrlimit(RLIMIT_AS, &memory);
#endif
}

[[noreturn]] void run_child(uint64_t memory_bytes, int result_pipe,
                            const std::function<Result<std::string>()>& function) {
  const rlimit no_core{0, 0};
  setrlimit(RLIMIT_CORE, &no_core);
  limit_memory(memory_bytes);
  const rlimit processor{1800, 1800};
  setrlimit(RLIMIT_CPU, &processor);
  const int nowhere = ::open("/dev/null", O_RDWR);
  if (nowhere >= 0) {
    for (const int descriptor : {0, 1, 2}) ::dup2(nowhere, descriptor);
  }
  auto result = function();
  const std::string& text = result ? *result : result.error().message;
  const ResultHeader header{static_cast<uint32_t>(result ? Status::ok : result.error().status)};
  const bool sent = write_all(result_pipe, text.data(), text.size()) &&
                    write_all(result_pipe, &header, sizeof header);
  ::_exit(sent ? 0 : 1);
}

}  // namespace

Result<std::string> run_isolated(const std::filesystem::path& path, uint64_t memory_bytes,
                                 const std::function<Result<std::string>()>& function) {
  const auto not_started = [&] {
    return fail(Status::io_error,
                fmt::format("{}: the process that reads it could not be started: {}", path.string(),
                            std::strerror(errno)));
  };
  int pipe_ends[2];
  if (::pipe2(pipe_ends, O_CLOEXEC) != 0) return not_started();
  const pid_t child = ::fork();
  if (child < 0) {
    ::close(pipe_ends[0]);
    ::close(pipe_ends[1]);
    return not_started();
  }
  if (child == 0) run_child(memory_bytes, pipe_ends[1], function);

  ::close(pipe_ends[1]);
  std::string text = read_to_end(pipe_ends[0]);
  ::close(pipe_ends[0]);
  int ended = 0;
  while (::waitpid(child, &ended, 0) < 0 && errno == EINTR) {
  }
  ResultHeader header{};
  if (text.size() >= sizeof header) {
    std::memcpy(&header, text.data() + text.size() - sizeof header, sizeof header);
  }
  if (text.size() < sizeof header || header.complete != ResultHeader::kComplete) {
    return fail(
        Status::malformed_volume,
        fmt::format("{}: its reader stopped ({}): the file is damaged; copy or export it again",
                    path.string(),
                    WIFSIGNALED(ended) ? strsignal(WTERMSIG(ended)) : "without a reason"));
  }
  text.resize(text.size() - sizeof header);
  const auto status = static_cast<Status>(header.status);
  if (status != Status::ok) return fail(status, std::move(text));
  return text;
}

Result<SharedBytes> SharedBytes::allocate(size_t size) {
  void* memory =
      size == 0 ? nullptr
                : ::mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) {
    return fail(Status::out_of_memory,
                fmt::format("{} bytes of memory could not be allocated", size));
  }
  return SharedBytes(std::span(static_cast<std::byte*>(memory), size));
}

SharedBytes::SharedBytes(SharedBytes&& other) noexcept : bytes_(std::exchange(other.bytes_, {})) {}

SharedBytes& SharedBytes::operator=(SharedBytes&& other) noexcept {
  std::swap(bytes_, other.bytes_);
  return *this;
}

SharedBytes::~SharedBytes() {
  if (!bytes_.empty()) ::munmap(bytes_.data(), bytes_.size());
}

}  // namespace isosplat::import
