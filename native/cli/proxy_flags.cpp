#include "native/cli/proxy_flags.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

namespace isosplat::cli {
namespace {

const std::map<std::string, server::ClientField>& client_fields() {
  static const std::map<std::string, server::ClientField> fields = {
      {"x-forwarded-for", server::ClientField::x_forwarded_for},
      {"forwarded", server::ClientField::forwarded},
      {"proxy-protocol", server::ClientField::proxy_protocol}};
  return fields;
}

}  // namespace

void ProxyFlags::add_to(CLI::App& command) {
  command
      .add_option("--trusted-proxy", trusted_proxies_,
                  "Address of a proxy in front of the server, such as 10.0.0.0/8 or 127.0.0.1. "
                  "Limits, rates and logs use the client address that this proxy reports")
      ->type_name("CIDR");
  command
      .add_option(
          "--proxy-header", proxy_header_,
          "How the proxy reports the client address: x-forwarded-for, forwarded or proxy-protocol")
      ->check(CLI::IsMember(client_fields()))
      ->capture_default_str();
  command
      .add_option("--user-header", user_header_,
                  "Header field in which the proxy reports the user's name")
      ->type_name("NAME");
  command
      .add_option("--groups-header", groups_header_,
                  "Header field in which the proxy reports the user's groups")
      ->type_name("NAME");
  command
      .add_option("--cookie-name", cookie_name_,
                  "Name of the cookies (default: isosplat-PORT). Give all servers behind a load "
                  "balancer the same name")
      ->type_name("NAME");
}

Result<void> ProxyFlags::apply(server::ServerOptions& options) const {
  options.proxy_fields = {client_fields().at(proxy_header_), user_header_, groups_header_};
  const auto parsed = server::TrustedProxies::parse(trusted_proxies_, options.proxy_fields);
  if (!parsed) return fail(parsed.error().status, "--trusted-proxy: " + parsed.error().message);
  options.trusted_proxies = trusted_proxies_;
  const bool is_name = std::ranges::all_of(cookie_name_, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-';
  });
  if (!is_name) {
    return fail(
        Status::invalid_argument,
        fmt::format("--cookie-name: expected letters, digits and -, found '{}'", cookie_name_));
  }
  options.cookie_name = cookie_name_;
  return {};
}

}  // namespace isosplat::cli
