#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "server/access/access_rules.h"
#include "server/http/message.h"
#include "server/http/target.h"

namespace isosplat::server {

/// The query parameters of a signed link, and that of a token (for the page only).
inline constexpr std::string_view kSignatureParameter = "sig";
inline constexpr std::string_view kExpiresParameter = "exp";
inline constexpr std::string_view kTokenParameter = "token";

/// The credentials of a request: Authorization: Bearer, cookies, and a signed link in its query.
/// `cookie`: the name of the cookie with a token; names of cookies with links are `cookie`,
/// "-link-" and the volume's name, or `cookie`, "-scene-" and the scene's name. Browsers send
/// cookies to every port of a host, so the name contains the server's port. At most kMaxCredentials
/// of each kind; further ones are ignored.
Credentials credentials_of(const Request& request, const Target& target, std::string_view cookie);
inline constexpr size_t kMaxCredentials = 16;

/// Removes a signed link from the query of a data request; the route checks the other parameters.
/// Returns 401 if the link is not valid, even if none is needed: otherwise each invalid link would
/// be another URL of the same resource. Without rules there are no links, and the query is not
/// changed.
std::optional<Response> take_link(Target& target, const std::shared_ptr<const AccessRules>& rules,
                                  uint64_t now);

struct CookieOptions {
  std::string name;
  bool is_secure = false;  ///< whether the connection has TLS: cookies are then sent over TLS only
};

/// For a page request with tokens in its query, unless the rules are open: a redirection to the
/// same page without tokens, which sets the cookie to the first valid token, so that neither
/// history nor bookmarks contain a token. 401 if none is valid. `now`: seconds since 1970.
std::optional<Response> exchange_token(const Target& target,
                                       const std::shared_ptr<const AccessRules>& rules,
                                       const CookieOptions& options, uint64_t now);

/// For a page request with a valid link: sets its cookie in `response`, so that the page's requests
/// have the link. The address keeps the link, so that users can pass it on.
void set_link_cookie(const Target& target, const std::shared_ptr<const AccessRules>& rules,
                     const CookieOptions& options, uint64_t now, Response& response);

/// 401: the request needs a token, or has no valid one.
Response unauthorized_response();

/// A target for the log: the values of tokens and signatures are replaced by "*".
std::string without_secrets(std::string_view target);

}  // namespace isosplat::server
