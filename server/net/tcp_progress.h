#pragma once

#include <cstdint>

namespace isosplat::server {

// The state of a TCP connection as the system reports it, by descriptor. If the descriptor is not a
// TCP socket, or is closed, the functions return 0 or do nothing.

/// Bytes that the other end has acknowledged so far.
uint64_t acknowledged_bytes(int socket);

/// Bytes that were written to the connection and are not acknowledged yet; 0 after a reset.
uint64_t unacknowledged_bytes(int socket);

/// The state of the other end: `open`; `ended`, if it has closed its sending side, but may still
/// read; `reset`, if the connection was reset.
enum class TcpEnd : uint8_t { open, ended, reset };
TcpEnd tcp_end(int socket);

/// Makes closing the descriptor reset the connection. Otherwise the system keeps sending the bytes
/// that the other end has not acknowledged, for as long as it receives a few now and then.
void reset_on_close(int socket);

}  // namespace isosplat::server
