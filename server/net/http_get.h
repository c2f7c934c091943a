#pragma once

#include <chrono>
#include <cstddef>
#include <string>
#include <string_view>

#include "shared/core/base/status.h"

namespace isosplat::server {

struct HttpGetOptions {
  std::chrono::milliseconds timeout{10'000};  ///< for all of it
  size_t max_bytes = 1 << 20;                 ///< of the body
  /// https: the certificate must be valid for the host, by the certificates that the system trusts.
  bool verifies_certificate = true;
};

struct HttpAnswer {
  int status = 0;
  std::string body;
};

/// Requests http://HOST[:PORT]/PATH or https://…, and waits for the answer; follows no redirection.
/// Errors: invalid_argument (not such an address), io_error (no answer, or a longer one).
Result<HttpAnswer> http_get(std::string_view url, const HttpGetOptions& options);

}  // namespace isosplat::server
