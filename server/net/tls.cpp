#include "server/net/tls.h"

#include <fmt/format.h>
#include <openssl/ssl.h>
#include <openssl/x509.h>

#include <ctime>
#include <string_view>
#include <utility>

namespace isosplat::server {
namespace {

using boost::system::error_code;

/// Selects http/1.1 from the protocols that the client offers. A client that offers only others,
/// such as h2, is refused (RFC 7301, 3.2).
int choose_protocol(SSL*, const unsigned char** chosen, unsigned char* chosen_bytes,
                    const unsigned char* offered, unsigned int offered_bytes, void*) {
  constexpr std::string_view kHttp11 = "http/1.1";
  std::string_view rest(reinterpret_cast<const char*>(offered), offered_bytes);
  while (!rest.empty()) {
    const auto bytes = static_cast<unsigned char>(rest.front());
    rest.remove_prefix(1);
    const std::string_view name = rest.substr(0, bytes);
    rest.remove_prefix(name.size());
    if (name != kHttp11) continue;
    *chosen = reinterpret_cast<const unsigned char*>(name.data());
    *chosen_bytes = bytes;
    return SSL_TLSEXT_ERR_OK;
  }
  return SSL_TLSEXT_ERR_ALERT_FATAL;
}

}  // namespace

int64_t certificate_end(TlsContext& context) {
  const X509* const certificate = SSL_CTX_get0_certificate(context.native_handle());
  std::tm end{};
  if (!certificate || ASN1_TIME_to_tm(X509_get0_notAfter(certificate), &end) != 1) return 0;
  return ::timegm(&end);
}

Result<std::shared_ptr<TlsContext>> load_tls(const std::filesystem::path& certificate,
                                             const std::filesystem::path& key) {
  auto context = std::make_shared<TlsContext>(TlsContext::tls_server);
  SSL_CTX* const native = context->native_handle();
  const auto failed = [](std::string_view what) {
    return fail(Status::io_error, fmt::format("TLS: OpenSSL has no {}", what));
  };
  if (SSL_CTX_set_min_proto_version(native, TLS1_2_VERSION) != 1) return failed("TLS 1.2");
  // All ciphers of TLS 1.3 have these properties.
  if (SSL_CTX_set_cipher_list(native, "ECDHE+AESGCM:ECDHE+CHACHA20") != 1) {
    return failed("cipher with forward secrecy");
  }
  SSL_CTX_set_options(
      native, SSL_OP_NO_COMPRESSION | SSL_OP_NO_RENEGOTIATION | SSL_OP_IGNORE_UNEXPECTED_EOF);
  // Reduces the memory of idle connections.
  SSL_CTX_set_mode(native, SSL_MODE_RELEASE_BUFFERS);
  constexpr std::string_view kSessions = "isosplat";
  SSL_CTX_set_session_id_context(native, reinterpret_cast<const unsigned char*>(kSessions.data()),
                                 kSessions.size());
  SSL_CTX_set_alpn_select_cb(native, choose_protocol, nullptr);

  error_code error;
  context->use_certificate_chain_file(certificate.string(), error);
  if (error) {
    return fail(Status::io_error, fmt::format("{}: expected a certificate and its chain (PEM): {}",
                                              certificate.string(), error.message()));
  }
  context->use_private_key_file(key.string(), TlsContext::pem, error);
  if (!error && SSL_CTX_check_private_key(native) == 1) return context;
  const std::string why = error ? error.message() : "it is not that of the certificate";
  return fail(Status::io_error, fmt::format("{}: expected the private key (PEM) of {}: {}",
                                            key.string(), certificate.string(), why));
}

}  // namespace isosplat::server
