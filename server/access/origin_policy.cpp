#include "server/access/origin_policy.h"

#include <arpa/inet.h>
#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace isosplat::server {
namespace {

std::string lower(std::string_view text) {
  std::string result(text);
  for (char& c : result) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return result;
}

bool is_number(std::string_view text) {
  return std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
}

/// Whether `host` (of host_of) is an IP address.
bool is_address(const std::string& host) {
  in6_addr address{};
  if (host.starts_with('[') && host.ends_with(']')) {
    return ::inet_pton(AF_INET6, host.substr(1, host.size() - 2).c_str(), &address) == 1;
  }
  return ::inet_pton(AF_INET, host.c_str(), &address) == 1;
}

struct Authority {
  std::string_view scheme;  ///< with "://"; empty if there is none
  std::string_view text;    ///< host and port
};

Authority authority_of_url(std::string_view url) {
  for (const std::string_view scheme : {"http://", "https://"}) {
    if (!url.starts_with(scheme)) continue;
    url.remove_prefix(scheme.size());
    return {scheme, url.substr(0, url.find_first_of("/?"))};
  }
  return {};
}

/// `authority` in lower case without the port that its scheme has by default.
std::string without_default_port(const Authority& authority) {
  std::string text = lower(authority.text);
  const std::string_view port = authority.scheme == "https://" ? ":443" : ":80";
  if (text.ends_with(port)) text.erase(text.size() - port.size());
  return text;
}

/// Whether a page of another origin made the request, according to the fields of the browser.
bool is_cross_origin(const Request& request) {
  // Browsers that send Sec-Fetch-Site set it themselves. A page on another port of localhost is
  // "same-site": it belongs to another program, and must not read volumes either.
  if (!request.sec_fetch_site.empty()) {
    return request.sec_fetch_site != "same-origin" && request.sec_fetch_site != "none";
  }
  if (request.origin.empty()) return false;
  const Authority origin = authority_of_url(request.origin);
  // Behind a proxy with TLS, the scheme of the page is https, but that of this request is http.
  return origin.text.empty() ||
         without_default_port(origin) != without_default_port({origin.scheme, request.host});
}

}  // namespace

std::string host_of(std::string_view authority) {
  size_t end = authority.find(':');
  if (authority.starts_with('[')) {
    end = authority.find(']');
    if (end == std::string_view::npos) return "";
    ++end;
  }
  const std::string_view host = authority.substr(0, end);
  const std::string_view rest = authority.substr(host.size());
  if (!rest.empty() && (rest.front() != ':' || !is_number(rest.substr(1)))) return "";
  return lower(host);
}

std::string_view authority_of(const Request& request) {
  const std::string_view in_target = authority_of_url(request.target).text;
  return in_target.empty() ? request.host : in_target;
}

Result<CrossOrigin> parse_cross_origin(std::string_view text) {
  CrossOrigin result;
  if (text == "*") {
    result.any = true;
    return result;
  }
  if (text == "none") return result;
  while (true) {
    const size_t comma = text.find(',');
    const std::string_view item = text.substr(0, comma);
    const Authority authority = authority_of_url(item);
    // Without a path, as browsers send it.
    const bool is_origin = !host_of(authority.text).empty() &&
                           authority.scheme.size() + authority.text.size() == item.size();
    const bool is_plain = std::all_of(item.begin(), item.end(), [](char c) {
      return c > 0x20 && c < 0x7f && c != '*' && c != '@' && c != ';' && c != '"';
    });
    if (!is_origin || !is_plain) {
      return fail(Status::invalid_argument,
                  fmt::format("expected \"*\", \"none\", or origins such as https://example.org "
                              "separated by commas, found \"{}\"",
                              item));
    }
    result.origins.push_back(
        fmt::format("{}{}", authority.scheme, without_default_port(authority)));
    if (comma == std::string_view::npos) return result;
    text.remove_prefix(comma + 1);
  }
}

OriginPolicy::OriginPolicy(AllowedHosts hosts, CrossOrigin cross_origin)
    : hosts_(std::move(hosts)), cross_origin_(std::move(cross_origin)) {
  hosts_.names.insert(hosts_.names.end(), {"localhost", "127.0.0.1", "[::1]"});
}

bool OriginPolicy::allows_host(const Request& request) const {
  if (hosts_.any) return true;
  const std::string_view authority = authority_of(request);
  if (authority.empty() && !request.has_host) return true;
  const std::string host = host_of(authority);
  return std::ranges::find(hosts_.names, host) != hosts_.names.end() ||
         (hosts_.any_address && is_address(host));
}

const std::string* OriginPolicy::listed_origin(const Request& request) const {
  const auto found = std::ranges::find(cross_origin_.origins, request.origin);
  return found == cross_origin_.origins.end() ? nullptr : &*found;
}

std::optional<Response> OriginPolicy::refuse(const Request& request, bool is_data) const {
  if (!allows_host(request)) {
    return error_response(403, "forbidden_host",
                          "Host: expected localhost, 127.0.0.1, [::1], or a name that the server "
                          "was started with: --allow-host NAME");
  }
  if (is_data && !cross_origin_.any && is_cross_origin(request) && !listed_origin(request)) {
    return error_response(403, "forbidden_origin",
                          "Origin: only pages of this server may read its data: start it with "
                          "--cors and the origin of the other page");
  }
  return std::nullopt;
}

void OriginPolicy::add_page_fields(const Request& request, Response& response) const {
  if (!cross_origin_.origins.empty())
    response.set("Vary", "Origin");  // in addition to Accept-Encoding
  const std::string* const listed = listed_origin(request);
  if (!cross_origin_.any && !listed) return;
  response.set("Access-Control-Allow-Origin", listed ? std::string_view(*listed) : "*");
  response.set("Cross-Origin-Resource-Policy", "cross-origin");
}

void OriginPolicy::add_fields(const Request& request, Response& response) const {
  const std::string* const listed = listed_origin(request);
  if (!cross_origin_.origins.empty()) response.set("Vary", "Origin");
  if (cross_origin_.any || listed) {
    const std::string_view readers = listed ? *listed : std::string_view("*");
    response.set("Access-Control-Allow-Origin", readers);
    response.set("Access-Control-Expose-Headers",
                 "Accept-Ranges, Content-Encoding, Content-Length, Content-Range, ETag, "
                 "Retry-After, X-Isosplat-Chunks, X-Isosplat-Dtype, X-Isosplat-Points");
    response.set("Timing-Allow-Origin", readers);
  }
  response.set("Cross-Origin-Resource-Policy", cross_origin_.any ? "cross-origin" : "same-origin");
}

}  // namespace isosplat::server
