#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "shared/core/base/status.h"

namespace isosplat::server {

/// The identity of a client, as stated by an identity provider or a trusted proxy.
struct Identity {
  std::string user;
  std::vector<std::string> groups;
};

/// Which tokens are valid, and which of their claims are used.
struct JwtOptions {
  std::string issuer;    ///< "iss"; empty: any
  std::string audience;  ///< "aud" must contain it
  std::string user_claim = "sub";
  std::string groups_claim = "groups";
};

/// Checks JSON Web Tokens (RFC 7519) that are signed with RS256 or ES256 by a key of a JSON Web Key
/// Set (RFC 7517). Rejects all others: "none", symmetric signatures, and keys in the token itself.
/// Thread-safe.
class JwtVerifier {
 public:
  /// `keys`: the key set. Keys for other purposes and algorithms are skipped; RSA keys must have
  /// 2048 to 8192 bits, EC keys the curve P-256. Errors (invalid_argument): not a key set, no
  /// usable key, or no audience.
  static Result<std::shared_ptr<const JwtVerifier>> create(std::string_view keys,
                                                           JwtOptions options);
  ~JwtVerifier();

  /// Whether a bearer token has the form of a JWT: three parts, separated by dots.
  static bool is_jwt(std::string_view token);

  /// The identity that a token states, if it is valid at `now` (seconds since 1970). Checks the
  /// signature, "exp" (required), "nbf", "iss" and "aud". Valid tokens are remembered until they
  /// expire, since each request has one. Errors (invalid_argument); messages contain no secrets.
  Result<Identity> verify(std::string_view token, uint64_t now) const;

  /// Longer tokens are refused before they are parsed.
  static constexpr size_t kMaxBytes = 8192;

 private:
  struct State;
  explicit JwtVerifier(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace isosplat::server
