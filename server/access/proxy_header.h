#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

#include "server/access/ip_address.h"

namespace isosplat::server {

/// A header of the PROXY protocol, version 1 or 2, at the beginning of a connection.
struct ProxyHeader {
  enum class State {
    partial,   ///< more bytes are needed
    complete,  ///< the header is the first `bytes` bytes
    malformed  ///< not a header, or one for which the connection must be closed
  };
  State state = State::partial;
  size_t bytes = 0;

  /// The client. No value if the proxy does not know it (UNKNOWN, AF_UNSPEC, AF_UNIX), or if the
  /// proxy itself is the client.
  std::optional<IpAddress> source;

  /// The proxy opened the connection itself, for a health check (the command LOCAL).
  bool is_local = false;
};

/// Parses a header. The text form of version 1 is
///
///     PROXY TCP4 192.0.2.7 198.51.100.1 56324 443 CR LF        (at most 107 bytes)
///
/// and that of version 2
///
///     byte   0                        12        13       14       16
///          +------------------------+---------+--------+--------+------------------ - -
///          | 0D 0A 0D 0A 00 … 0A    | version | family | length | addresses, then TLVs
///          |                        | command | proto  |   BE   |
///          +------------------------+---------+--------+--------+------------------ - -
///
/// TLVs are skipped; a length above kMaxProxyHeader is malformed, as are datagrams. Source: The
/// PROXY protocol, versions 1 & 2, W. Tarreau, sections 2.1 and 2.2.
ProxyHeader parse_proxy_header(std::string_view received);

/// The longest accepted header, in bytes: addresses, and space for the TLVs of TLS.
inline constexpr size_t kMaxProxyHeader = 4096;

}  // namespace isosplat::server
