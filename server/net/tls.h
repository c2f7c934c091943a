#pragma once

#include <boost/asio/ssl/context.hpp>
#include <cstdint>
#include <filesystem>
#include <memory>

#include "shared/core/base/status.h"

namespace isosplat::server {

using TlsContext = boost::asio::ssl::context;

/// The settings of a server's TLS connections: TLS 1.2 and 1.3, ciphers with forward secrecy and
/// authentication, no compression, no renegotiation, resumption by tickets, ALPN http/1.1. Both
/// files are PEM: the certificate with its chain, the server's own first, and its private key.
/// Errors: io_error (a file cannot be read, or the key is not the certificate's).
Result<std::shared_ptr<TlsContext>> load_tls(const std::filesystem::path& certificate,
                                             const std::filesystem::path& key);

/// The expiry time of the server's certificate, in seconds since 1970; 0 if there is no
/// certificate.
int64_t certificate_end(TlsContext& context);

}  // namespace isosplat::server
