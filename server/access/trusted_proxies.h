#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "server/access/ip_address.h"
#include "shared/core/base/status.h"

namespace isosplat::server {

/// How proxies tell the address of their client. One of them only: a proxy passes on the fields
/// that it does not set itself, so a client could choose the content of another one.
enum class ClientField : uint8_t {
  x_forwarded_for,  ///< X-Forwarded-For, and X-Forwarded-Proto
  forwarded,        ///< Forwarded (RFC 7239)
  proxy_protocol    ///< a header of the PROXY protocol before the first byte (parse_proxy_header)
};

/// What proxies say in the fields of requests.
struct ProxyFields {
  ClientField client = ClientField::x_forwarded_for;
  // Names of the fields with the client's user name, and its groups, separated by commas, which a
  // proxy that checks who the client is sets on each request; empty: none.
  std::string user;
  std::string groups;
};

/// The proxies whose word counts.
class TrustedProxies {
 public:
  TrustedProxies() = default;

  /// Errors (invalid_argument): a range is malformed, fields of the client's identity are given
  /// without a range, or they are not names of fields.
  static Result<TrustedProxies> parse(const std::vector<std::string>& ranges, ProxyFields fields);

  const ProxyFields& fields() const { return fields_; }

  bool trusts(const IpAddress& address) const;

  /// Whether connections from this peer begin with a header of the PROXY protocol.
  bool send_proxy_header(const IpAddress& peer) const {
    return fields_.client == ClientField::proxy_protocol && trusts(peer);
  }

  /// A request's origin, as far as it is known.
  struct Client {
    IpAddress address;
    bool has_tls = false;  ///< the proxy says that its client uses TLS
  };

  /// The client of a request that came from `peer`. `addresses`: the content of X-Forwarded-For or
  /// Forwarded, the lines of several fields joined by commas. Its items are taken from the right,
  /// where the nearest proxy added the last one, up to the first address that is not trusted:
  /// everything to the left of it may come from the client. An item that is no address ends the
  /// search, and the proxy that added it is the client. `scheme`: X-Forwarded-Proto.
  Client client_of(const IpAddress& peer, std::string_view addresses,
                   std::string_view scheme) const;

 private:
  std::vector<AddressRange> ranges_;
  ProxyFields fields_;
};

}  // namespace isosplat::server
