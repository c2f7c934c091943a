#pragma once

#include <chrono>
#include <cstddef>
#include <string>
#include <string_view>

#include "shared/core/base/status.h"

namespace isosplat::server {

struct HttpGetOptions {
  std::chrono::milliseconds timeout{10'000};  ///< for the whole request
  size_t max_bytes = 1 << 20;                 ///< of the body
  /// For https: the certificate must be valid for the host, and trusted by the system.
  bool verifies_certificate = true;
};

struct HttpAnswer {
  int status = 0;
  std::string body;
};

/// Requests http://HOST[:PORT]/PATH or https://…, and waits for the response. Follows no
/// redirection. Errors: invalid_argument (not such a URL), io_error (no response, or a body above
/// the limit).
Result<HttpAnswer> http_get(std::string_view url, const HttpGetOptions& options);

}  // namespace isosplat::server
