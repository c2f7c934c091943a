#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "server/access/ip_address.h"
#include "shared/core/base/status.h"

namespace isosplat::server {

/// The header in which proxies state the address of their client. Only one is used: a proxy
/// forwards fields that it does not set, so a client could forge the others.
enum class ClientField : uint8_t {
  x_forwarded_for,  ///< X-Forwarded-For, and X-Forwarded-Proto
  forwarded,        ///< Forwarded (RFC 7239)
  proxy_protocol    ///< a header of the PROXY protocol before the first byte (parse_proxy_header)
};

/// The fields in which proxies describe the client of a request.
struct ProxyFields {
  ClientField client = ClientField::x_forwarded_for;
  // Names of the fields with the client's user name and its groups (separated by commas). A proxy
  // that authenticates clients sets them on each request; empty: none.
  std::string user;
  std::string groups;
};

/// The proxies that the server trusts to state the address and identity of their clients.
class TrustedProxies {
 public:
  TrustedProxies() = default;

  /// Errors (invalid_argument): a range is malformed, fields of the client's identity are given
  /// without a range, or they are not valid names of fields.
  static Result<TrustedProxies> parse(const std::vector<std::string>& ranges, ProxyFields fields);

  const ProxyFields& fields() const { return fields_; }

  bool trusts(const IpAddress& address) const;

  /// Whether connections from this peer begin with a header of the PROXY protocol.
  bool send_proxy_header(const IpAddress& peer) const {
    return fields_.client == ClientField::proxy_protocol && trusts(peer);
  }

  /// The origin of a request.
  struct Client {
    IpAddress address;
    bool has_tls = false;  ///< whether the proxy states that its client uses TLS
  };

  /// The client of a request that came from `peer`. `addresses`: the content of X-Forwarded-For or
  /// Forwarded, with several fields joined by commas. The nearest proxy has added the rightmost
  /// item. The items are therefore examined from right to left, up to the first address that is not
  /// trusted; a client could have forged the items further left. An item that is not an address
  /// ends the search, and the proxy that added it counts as the client. `scheme`:
  /// X-Forwarded-Proto.
  Client client_of(const IpAddress& peer, std::string_view addresses,
                   std::string_view scheme) const;

 private:
  std::vector<AddressRange> ranges_;
  ProxyFields fields_;
};

}  // namespace isosplat::server
