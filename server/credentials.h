#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "server/access_rules.h"
#include "server/message.h"
#include "server/target.h"

namespace isosplat {

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

/// Removes a signed link from the query of a data request, whose parameters are checked strictly.
void remove_link(Target& target);

struct CookieOptions {
  std::string name;
  bool is_secure = false;  ///< the connection has TLS: the cookies are for such connections only
};

/// For a page request with a token in its query, unless the rules are open: a redirection to the
/// same page without the token, which sets the cookie, so that neither history nor bookmarks hold
/// the token. 401 if the token is not valid. `now`: seconds since 1970.
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

}  // namespace isosplat
