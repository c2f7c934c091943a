#include "native/cli/proxy_flags.h"

#include <map>

namespace isosplat::cli {
namespace {

const std::map<std::string, ClientField>& client_fields() {
  static const std::map<std::string, ClientField> fields = {
      {"x-forwarded-for", ClientField::x_forwarded_for},
      {"forwarded", ClientField::forwarded},
      {"proxy-protocol", ClientField::proxy_protocol}};
  return fields;
}

}  // namespace

void ProxyFlags::add_to(CLI::App& command) {
  command
      .add_option("--trusted-proxy", trusted_proxies_,
                  "Address of a proxy in front (10.0.0.0/8, 127.0.0.1): limits, rates and logs "
                  "use the client's address that it states")
      ->type_name("CIDR");
  command
      .add_option("--proxy-header", proxy_header_,
                  "Where it states it: x-forwarded-for, forwarded or proxy-protocol")
      ->check(CLI::IsMember(client_fields()))
      ->capture_default_str();
}

Result<void> ProxyFlags::apply(ServerOptions& options) const {
  const Result<TrustedProxies> parsed =
      TrustedProxies::parse(trusted_proxies_, client_fields().at(proxy_header_));
  if (!parsed) return fail(parsed.error().status, "--trusted-proxy: " + parsed.error().message);
  options.trusted_proxies = trusted_proxies_;
  options.client_field = parsed->field();
  return {};
}

}  // namespace isosplat::cli
