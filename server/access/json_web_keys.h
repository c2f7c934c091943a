#pragma once

#include <openssl/evp.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "shared/core/base/status.h"

namespace isosplat::server {

/// The signature algorithms of tokens that are accepted (RFC 7518, 3.3 and 3.4).
enum class JwtAlgorithm : uint8_t { rs256, es256 };

/// A public key for signatures of one algorithm.
struct JsonWebKey {
  struct Free {
    void operator()(EVP_PKEY* freed) const { EVP_PKEY_free(freed); }
  };
  std::string id;  ///< "kid"; may be empty
  JwtAlgorithm algorithm = JwtAlgorithm::rs256;
  std::unique_ptr<EVP_PKEY, Free> key;

  /// Whether `signature`, in the encoding of tokens, is a valid signature of `text`.
  bool verifies(std::string_view text, std::string_view signature) const;
};

/// The keys of a JSON Web Key Set that can verify RS256 (RSA, 2048 to 8192 bits) or ES256 (P-256);
/// at most 64. Others are skipped. Errors (invalid_argument): not a key set, a key with
/// contradictory members, or no usable key.
Result<std::vector<JsonWebKey>> parse_json_web_keys(std::string_view text);

/// Decodes base64url without padding (RFC 7515, 2). No value if malformed.
std::optional<std::string> decode_base64url(std::string_view text);

}  // namespace isosplat::server
