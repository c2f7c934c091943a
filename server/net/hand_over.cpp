#include "server/net/hand_over.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>
#include <system_error>

extern char** environ;

namespace isosplat::server {
namespace {

constexpr const char* kVariable = "ISOSPLAT_HAND_OVER";
constexpr int kReadyPipe = 3, kFirstSocket = 4;
constexpr unsigned kMostSockets = 64;

bool has_predecessor = false;

/// Descriptors that are closed in the destructor.
struct Descriptors : std::vector<int> {
  Descriptors() = default;
  Descriptors(const Descriptors&) = delete;
  Descriptors& operator=(const Descriptors&) = delete;
  ~Descriptors() {
    for (const int descriptor : *this) ::close(descriptor);
  }
};

/// The file that this process runs, or the file that has replaced it at its path.
std::string program_path() {
  std::error_code error;
  std::string path = std::filesystem::read_symlink("/proc/self/exe", error).string();
  constexpr std::string_view kReplaced = " (deleted)";
  if (path.ends_with(kReplaced)) path.resize(path.size() - kReplaced.size());
  return path;
}

/// Pointers to zero-terminated texts, in the form of the arguments of main() and exec.
std::vector<char*> pointers_to(std::vector<std::string>& texts) {
  std::vector<char*> pointers;
  for (std::string& text : texts) pointers.push_back(text.data());
  pointers.push_back(nullptr);
  return pointers;
}

std::vector<std::string> arguments_of_this_process() {
  std::ifstream file("/proc/self/cmdline", std::ios::binary);
  std::vector<std::string> arguments;
  for (std::string argument; std::getline(file, argument, '\0');) arguments.push_back(argument);
  return arguments;
}

std::vector<std::string> environment_with(const std::string& variable) {
  std::vector<std::string> variables;
  for (char** each = environ; *each; ++each) variables.emplace_back(*each);
  variables.push_back(variable);
  return variables;
}

}  // namespace

Result<Successor> start_successor(const ListeningSockets& sockets) {
  const auto failed = [](std::string_view what, int error) {
    return fail(Status::io_error,
                fmt::format("cannot start a new process: {}: {}", what, std::strerror(error)));
  };
  int pipe[2] = {-1, -1};
  if (::pipe2(pipe, O_CLOEXEC) != 0) return failed("pipe", errno);
  std::vector<int> given = {pipe[1]};
  std::ranges::copy(sockets.serving, std::back_inserter(given));
  std::ranges::copy(sockets.redirecting, std::back_inserter(given));
  // Duplicate the descriptors to numbers above all those that the successor gets, so that none is
  // overwritten before it is used.
  Descriptors copies;
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  int error = 0;
  for (size_t i = 0; i < given.size() && error == 0; ++i) {
    const int copy =
        ::fcntl(given[i], F_DUPFD_CLOEXEC, kFirstSocket + static_cast<int>(kMostSockets));
    if (copy < 0) {
      error = errno;
      break;
    }
    copies.push_back(copy);
    error = ::posix_spawn_file_actions_adddup2(&actions, copy, kReadyPipe + static_cast<int>(i));
  }
  ::close(pipe[1]);
  // Child processes inherit Asio's sockets. If they stayed open there, clients would not see the
  // end of connections that this process has closed.
  if (error == 0) {
    error = ::posix_spawn_file_actions_addclosefrom_np(&actions,
                                                       kReadyPipe + static_cast<int>(given.size()));
  }
  Successor successor{-1, pipe[0]};
  const std::string program = program_path();
  std::vector<std::string> arguments = arguments_of_this_process();
  std::vector<std::string> variables = environment_with(
      fmt::format("{}={}:{}", kVariable, sockets.serving.size(), sockets.redirecting.size()));
  if (error == 0) {
    error = ::posix_spawn(&successor.process, program.c_str(), &actions, nullptr,
                          pointers_to(arguments).data(), pointers_to(variables).data());
  }
  ::posix_spawn_file_actions_destroy(&actions);
  if (error == 0) return successor;
  ::close(pipe[0]);
  return failed(program, error);
}

std::optional<ListeningSockets> take_handed_sockets() {
  const char* const text = std::getenv(kVariable);
  if (!text) return std::nullopt;
  const std::string counts = text;
  ::unsetenv(kVariable);
  unsigned serving = 0, redirecting = 0;
  const char* const end = counts.data() + counts.size();
  const auto first = std::from_chars(counts.data(), end, serving);
  if (first.ec != std::errc() || first.ptr == end || *first.ptr != ':') return std::nullopt;
  const auto second = std::from_chars(first.ptr + 1, end, redirecting);
  if (second.ec != std::errc() || second.ptr != end || serving == 0 || serving > kMostSockets ||
      redirecting > kMostSockets - serving) {
    return std::nullopt;
  }
  has_predecessor = true;
  ::fcntl(kReadyPipe, F_SETFD, FD_CLOEXEC);
  ListeningSockets sockets;
  for (unsigned i = 0; i < serving + redirecting; ++i) {
    const int socket = kFirstSocket + static_cast<int>(i);
    ::fcntl(socket, F_SETFD, FD_CLOEXEC);
    (i < serving ? sockets.serving : sockets.redirecting).push_back(socket);
  }
  return sockets;
}

void notify_predecessor() {
  if (!has_predecessor) return;
  has_predecessor = false;
  const char byte = 1;
  [[maybe_unused]] const ssize_t written = ::write(kReadyPipe, &byte, 1);
  ::close(kReadyPipe);
}

}  // namespace isosplat::server
