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
/// `cookie`: the name of the cookie with a token; cookies with links are called `cookie`, "-link-"
/// and the volume's name. A browser sends cookies to every port of a host: the name has the
/// server's. At most kMaxCredentials of each kind; further ones are ignored.
Credentials credentials_of(const Request& request, const Target& target, std::string_view cookie);
inline constexpr size_t kMaxCredentials = 16;

/// Takes a signed link out of the query of a data request, whose other parameters the route checks.
/// 401 if it is not valid, also where none is needed: each wrong link would be another URL of the
/// same resource. Without rules there are no links: the query stays as it is.
std::optional<Response> take_link(Target& target, const std::shared_ptr<const AccessRules>& rules,
                                  uint64_t now);

struct CookieOptions {
  std::string name;
  bool is_secure = false;  ///< the connection has TLS: the cookies are for such connections only
};

/// For a page request with tokens in its query, unless the rules are open: a redirection to the
/// same page without them, which sets the cookie to the first valid one, so that neither history
/// nor bookmarks hold a token. 401 if none is valid. `now`: seconds since 1970.
std::optional<Response> exchange_token(const Target& target,
                                       const std::shared_ptr<const AccessRules>& rules,
                                       const CookieOptions& options, uint64_t now);

/// For a page request with a valid link: sets its cookie in `response`, so that the page's requests
/// have it. The address keeps the link, which is made to be passed on.
void set_link_cookie(const Target& target, const std::shared_ptr<const AccessRules>& rules,
                     const CookieOptions& options, uint64_t now, Response& response);

/// 401: a token is needed, or none of those given is valid.
Response unauthorized_response();

/// A target for the log: the values of tokens and signatures are replaced by "*".
std::string without_secrets(std::string_view target);

}  // namespace isosplat::server
