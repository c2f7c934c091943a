#include "server/net/service_manager.h"

#include <fcntl.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <charconv>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <string>

// The two protocols take a few lines, and are stable (systemd's Interface Portability and Stability
// Promise), so they are not worth the dependency on libsystemd.

namespace isosplat::server {
namespace {

/// The whole number in a variable of the environment; -1 if there is none.
long number_in(const char* variable) {
  const char* text = std::getenv(variable);
  if (!text) return -1;
  long number = -1;
  const char* const end = text + std::strlen(text);
  const auto [rest, error] = std::from_chars(text, end, number);
  return error == std::errc() && rest == end ? number : -1;
}

}  // namespace

std::vector<int> take_passed_sockets() {
  constexpr int kFirst = 3;
  constexpr long kMost = 64;
  const long process = number_in("LISTEN_PID"), count = number_in("LISTEN_FDS");
  for (const char* variable : {"LISTEN_PID", "LISTEN_FDS", "LISTEN_FDNAMES"}) ::unsetenv(variable);
  std::vector<int> sockets;
  if (process != ::getpid() || count > kMost) return sockets;
  for (int i = 0; i < count; ++i) {
    ::fcntl(kFirst + i, F_SETFD, FD_CLOEXEC);
    sockets.push_back(kFirst + i);
  }
  return sockets;
}

bool has_service_manager() {
  return std::getenv("NOTIFY_SOCKET") != nullptr;
}

void notify_service_manager(std::string_view state) {
  const char* const path = std::getenv("NOTIFY_SOCKET");
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  // "@…" is an abstract socket, whose name begins with a zero byte.
  if (!path || (path[0] != '/' && path[0] != '@')) return;
  const size_t length = std::strlen(path);
  if (length >= sizeof address.sun_path) return;
  std::memcpy(address.sun_path, path, length);
  if (path[0] == '@') address.sun_path[0] = '\0';
  const int socket = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (socket < 0) return;
  ::sendto(socket, state.data(), state.size(), MSG_NOSIGNAL,
           reinterpret_cast<const sockaddr*>(&address),
           static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + length));
  ::close(socket);
}

void notify_reloading() {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  notify_service_manager("RELOADING=1\nMONOTONIC_USEC=" +
                         std::to_string(now.tv_sec * 1'000'000 + now.tv_nsec / 1'000));
}

}  // namespace isosplat::server
