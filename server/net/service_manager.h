#pragma once

#include <string_view>
#include <vector>

namespace isosplat::server {

/// The listening sockets that systemd (or a program with the same protocol, sd_listen_fds(3))
/// passed to this process; none without LISTEN_PID and LISTEN_FDS. Removes the variables from the
/// environment, so that a second call returns none. Not thread-safe.
std::vector<int> take_passed_sockets();

/// Whether systemd, or a program with the same protocol, waits for notify_service_manager().
bool has_service_manager();

/// Sends a state to systemd, such as "READY=1" (sd_notify(3)). Does nothing without NOTIFY_SOCKET.
void notify_service_manager(std::string_view state);

/// Reports to systemd that a reload begins. "READY=1" ends it.
void notify_reloading();

}  // namespace isosplat::server
