#pragma once

#include <cstdint>

namespace isosplat::server {

// What the system knows of a TCP connection, by its descriptor. The functions may be called with a
// descriptor that is not a TCP socket, or closed: they then return 0, or do nothing.

/// Bytes that the other end has acknowledged so far.
uint64_t acknowledged_bytes(int socket);

/// Bytes that were written to the connection and are not acknowledged yet; 0 once it is reset.
uint64_t unacknowledged_bytes(int socket);

/// Whether the other end still holds the connection: `open`; it has ended its side, and may still
/// read, or not: `ended`; the connection is reset: `reset`.
enum class TcpEnd : uint8_t { open, ended, reset };
TcpEnd tcp_end(int socket);

/// Closing the descriptor then resets the connection. Otherwise the system goes on to send what the
/// other end has not acknowledged, for as long as this end takes a little of it now and then.
void reset_on_close(int socket);

}  // namespace isosplat::server
