#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/http/message.h"
#include "shared/core/base/status.h"

namespace isosplat::server {

/// The pages of other origins that may read data responses (CORS). By default only pages of this
/// server may.
struct CrossOrigin {
  bool any = false;                  ///< every page: Access-Control-Allow-Origin: *
  std::vector<std::string> origins;  ///< or the pages of these origins, such as "https://a.example"
};

/// Parses "*", "none", or a list "https://a.example,https://b.example:8443". Errors
/// (invalid_argument) name the item.
Result<CrossOrigin> parse_cross_origin(std::string_view text);

/// The host names that requests may have. An attacker can make the name of a page resolve to the
/// address of this server (DNS rebinding), so that browsers treat the server as the same origin as
/// the page. The requests of such a page name the attacker's host.
struct AllowedHosts {
  bool any = false;
  bool any_address = false;        ///< every IP address, since an attacker cannot own one as a name
  std::vector<std::string> names;  ///< in lower case, without a port; IPv6 addresses in brackets
};

/// The host of "host", "host:port", "[::1]:port" in lower case, without the port. Empty if
/// malformed.
std::string host_of(std::string_view authority);

/// The host and optional port of a request. An absolute target takes precedence over the field (RFC
/// 9112, 3.2.2).
std::string_view authority_of(const Request& request);

/// Decides which hosts a request may name, and which pages may read data. Immutable.
class OriginPolicy {
 public:
  /// By default localhost, and only the server's own pages.
  OriginPolicy() : OriginPolicy(AllowedHosts{}, CrossOrigin{}) {}

  /// localhost, 127.0.0.1 and [::1] are always allowed.
  OriginPolicy(AllowedHosts hosts, CrossOrigin cross_origin);

  /// The same hosts, and no pages of other origins.
  OriginPolicy for_own_pages() const { return {hosts_, CrossOrigin{}}; }

  /// 403 for a request that names a host that is not allowed. If `is_data`, also 403 for a request
  /// of a page of another origin that may not read data. Requests without Host (HTTP/1.0), and
  /// without Origin and Sec-Fetch-Site, do not come from a page in a browser.
  std::optional<Response> refuse(const Request& request, bool is_data) const;

  /// Adds the fields that allow pages of other origins to run and read a file of the page, since
  /// they may use its script `isosplat-viewer.js`. The origins are the same as for data.
  void add_page_fields(const Request& request, Response& response) const;

  /// Adds the fields that state which pages may read this data response.
  void add_fields(const Request& request, Response& response) const;

  /// The same for a response to a request that was not read.
  void add_fields(Response& response) const { add_fields(Request{}, response); }

 private:
  bool allows_host(const Request& request) const;
  const std::string* listed_origin(const Request& request) const;

  AllowedHosts hosts_;
  CrossOrigin cross_origin_;
};

}  // namespace isosplat::server
