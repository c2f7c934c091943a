#include "server/access/https.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <string_view>

#include "server/access/origin_policy.h"

namespace isosplat::server {
namespace {

bool is_letter_or_digit(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
}

/// Whether a result of host_of() has the form of a name or an address.
bool is_host(std::string_view host) {
  return !host.empty() && std::ranges::all_of(host, [](char c) {
    return is_letter_or_digit(c) || std::string_view("-._:[]").find(c) != std::string_view::npos;
  });
}

/// The path and query of a target; characters that are not allowed in a URL are escaped.
std::string path_of(std::string_view target) {
  if (!target.starts_with('/')) {
    const size_t host = target.find("//");
    const size_t path = host == target.npos ? target.npos : target.find_first_of("/?", host + 2);
    target = path == target.npos ? std::string_view() : target.substr(path);
  }
  std::string result = target.starts_with('/') ? "" : "/";
  for (const char c : target) {
    const bool is_plain =
        is_letter_or_digit(c) || std::string_view("-._~!$&'()*+,;=:@/?%").find(c) != target.npos;
    result += is_plain ? std::string(1, c) : fmt::format("%{:02X}", static_cast<unsigned char>(c));
  }
  return result;
}

}  // namespace

Response HttpsPolicy::redirect(const Request& request) const {
  const std::string host = host_of(authority_of(request));
  if (!is_host(host)) {
    return error_response(400, "bad_request", "expected https, or a request that names a host");
  }
  Response response;
  response.status = 308;
  response.set("Location",
               fmt::format("https://{}{}{}", host, port == 443 ? "" : fmt::format(":{}", port),
                           path_of(request.target)));
  response.set("Cache-Control", "no-store");
  return response;
}

void HttpsPolicy::add_fields(const Request& request, Response& response) const {
  if (hsts_seconds == 0 || !request.has_tls) return;
  response.set("Strict-Transport-Security", fmt::format("max-age={}", hsts_seconds));
}

}  // namespace isosplat::server
