#include "server/net/tcp_progress.h"

#include <linux/sockios.h>
#include <linux/tcp.h>
#include <netinet/in.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

namespace isosplat::server {
namespace {

// Of the kernel's tcp_states.h.
constexpr uint8_t kClosed = 7;     // TCP_CLOSE: after a reset
constexpr uint8_t kCloseWait = 8;  // TCP_CLOSE_WAIT: the other end has closed its sending side

tcp_info information_of(int socket) {
  tcp_info information{};
  socklen_t bytes = sizeof information;
  if (::getsockopt(socket, IPPROTO_TCP, TCP_INFO, &information, &bytes) != 0) return {};
  return information;
}

}  // namespace

uint64_t acknowledged_bytes(int socket) {
  return information_of(socket).tcpi_bytes_acked;
}

uint64_t unacknowledged_bytes(int socket) {
  int bytes = 0;
  if (::ioctl(socket, SIOCOUTQ, &bytes) != 0 || bytes <= 0) return 0;
  // After a reset, the system still counts the bytes that it has dropped.
  return information_of(socket).tcpi_state == kClosed ? 0 : static_cast<uint64_t>(bytes);
}

TcpEnd tcp_end(int socket) {
  const uint8_t state = information_of(socket).tcpi_state;
  return state == kClosed ? TcpEnd::reset : state == kCloseWait ? TcpEnd::ended : TcpEnd::open;
}

void reset_on_close(int socket) {
  const linger at_once{1, 0};
  ::setsockopt(socket, SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
}

}  // namespace isosplat::server
