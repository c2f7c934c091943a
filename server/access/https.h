#pragma once

#include <cstdint>

#include "server/http/message.h"

namespace isosplat::server {

/// The response fields and redirections that make clients use TLS.
struct HttpsPolicy {
  /// The time during which browsers use only https for this host (Strict-Transport-Security, RFC
  /// 6797), in seconds; 0: not stated.
  uint64_t hsts_seconds = 0;
  uint16_t port = 443;  ///< of https, in redirections

  /// 308 to the same address with https, for a request whose host is allowed
  /// (OriginPolicy::refuse); 400 if the request names no host.
  Response redirect(const Request& request) const;

  /// Adds Strict-Transport-Security to the response to a client that uses TLS.
  void add_fields(const Request& request, Response& response) const;
};

}  // namespace isosplat::server
