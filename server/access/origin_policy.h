#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/http/message.h"
#include "shared/core/base/status.h"

namespace isosplat::server {

/// The pages of other origins that may read data responses (CORS). By default none: only pages that
/// the server sent itself.
struct CrossOrigin {
  bool any = false;                  ///< every page: Access-Control-Allow-Origin: *
  std::vector<std::string> origins;  ///< or the pages of these origins, such as "https://a.example"
};

/// Parses "*", "none", or a list "https://a.example,https://b.example:8443". Errors
/// (invalid_argument) name the item.
Result<CrossOrigin> parse_cross_origin(std::string_view text);

/// The host names that a request may be for. A page of an attacker can give its own name the
/// address of this server (DNS rebinding): a browser then takes the server for a part of that page.
/// Its requests name the attacker's host.
struct AllowedHosts {
  bool any = false;
  bool any_address = false;        ///< every IP address: no name that an attacker could own
  std::vector<std::string> names;  ///< in lower case, without a port; IPv6 addresses in brackets
};

/// The host of "host", "host:port", "[::1]:port" in lower case, without the port. Empty if
/// malformed.
std::string host_of(std::string_view authority);

/// The host, and perhaps port, that a request is for: that of an absolute target counts, not the
/// field (RFC 9112, 3.2.2).
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

  /// 403 for a request that names a host that is not allowed, and, if `is_data`, for one that a
  /// page of another origin made that may not read data. Requests without Host (HTTP/1.0) and
  /// without Origin and Sec-Fetch-Site are not from a page in a browser.
  std::optional<Response> refuse(const Request& request, bool is_data) const;

  /// Adds the fields that say which pages of other origins may run and read a file of the page: its
  /// script `isosplat-viewer.js` is for them, too. The same origins as for data.
  void add_page_fields(const Request& request, Response& response) const;

  /// Adds the fields that say which pages may read this data response.
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
