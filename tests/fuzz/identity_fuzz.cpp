// Texts that state the identity of a client: headers of the PROXY protocol, Forwarded and
// X-Forwarded-For, JSON Web Tokens and key sets, and files of revoked links.

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <string>
#include <string_view>

#include "server/access/access_rules.h"
#include "server/access/json_web_keys.h"
#include "server/access/jwt.h"
#include "server/access/proxy_header.h"
#include "server/access/trusted_proxies.h"

namespace {

using namespace isosplat;
using namespace isosplat::server;

void require(bool condition) {
  if (!condition) std::abort();
}

/// The public key of the example in RFC 7515, A.3. The fuzzer does not have its private key.
constexpr std::string_view kKeys =
    R"({"keys":[{"kty":"EC","crv":"P-256","kid":"e",
        "x":"f83OJ3D2xF1Bg8vub9tLe1gHMzV76e8Tus9uPHvRVEU",
        "y":"x_FEzRu9m36HLN_tue659LNpXW6pCyStikYjKIWI5a0"}]})";

void try_proxy_header(std::string_view text) {
  const ProxyHeader header = parse_proxy_header(text);
  require(header.bytes <= std::min(text.size(), kMaxProxyHeader));
  if (header.state != ProxyHeader::State::complete) return;
  // The end of the header does not depend on the bytes after it.
  const ProxyHeader alone = parse_proxy_header(text.substr(0, header.bytes));
  require(alone.state == header.state && alone.bytes == header.bytes);
  require(alone.source == header.source);
}

void try_forwarded(std::string_view text) {
  static const IpAddress peer = *IpAddress::parse("10.0.0.1");
  for (const ClientField field : {ClientField::x_forwarded_for, ClientField::forwarded}) {
    static const std::vector<std::string> ranges = {"10.0.0.0/8"};
    const auto proxies = TrustedProxies::parse(ranges, {.client = field, .user = "", .groups = ""});
    const bool is_rfc_7239 = field == ClientField::forwarded;
    // Whatever a client sends, only the item that the proxy has added to its right counts.
    const std::string list = std::string(text) + (is_rfc_7239 ? ", for=192.0.2.7" : ", 192.0.2.7");
    require(proxies->client_of(peer, list, {}).address == IpAddress::parse("192.0.2.7"));
    require(!proxies->client_of(peer, text, {}).address.text().empty());
  }
}

void try_token(std::string_view text) {
  static const auto verifier = JwtVerifier::create(kKeys, {.issuer = "", .audience = "isosplat"});
  require(verifier.has_value());
  require(!(*verifier)->verify(text, 1'800'000'000));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try_proxy_header(text);
  try_forwarded(text);
  try_token(text);
  if (const auto keys = parse_json_web_keys(text)) {
    require(!keys->empty());
    for (const JsonWebKey& key : *keys) key.verifies(text, text);
  }
  AccessRules rules;
  (void)rules.add_revoked_links(text);
  return 0;
}
