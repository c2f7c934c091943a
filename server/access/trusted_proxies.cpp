#include "server/access/trusted_proxies.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

namespace isosplat::server {
namespace {

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlanks = " \t";
  text.remove_prefix(std::min(text.find_first_not_of(kBlanks), text.size()));
  return text.substr(0, text.find_last_not_of(kBlanks) + 1);
}

/// Removes and returns the text behind the last `separator` outside of quotes. Quotes are matched
/// from the right, so that a quote that a client left open further to the left has no effect.
std::string_view take_last(std::string_view& text, char separator) {
  bool is_quoted = false;
  for (size_t at = text.size(); at > 0; --at) {
    const char c = text[at - 1];
    if (c == '"') is_quoted = !is_quoted;
    if (c != separator || is_quoted) continue;
    const std::string_view item = text.substr(at);
    text = text.substr(0, at - 1);
    return trimmed(item);
  }
  return trimmed(std::exchange(text, {}));
}

bool equals_ignoring_case(std::string_view text, std::string_view small) {
  return std::ranges::equal(text, small, {}, [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  });
}

/// "192.0.2.7", "192.0.2.7:47011", "2001:db8::7", "[2001:db8::7]" or "[2001:db8::7]:47011".
std::optional<IpAddress> parse_node(std::string_view node) {
  std::string_view port;
  if (node.starts_with('[')) {
    const size_t end = node.find(']');
    if (end == std::string_view::npos) return std::nullopt;
    port = node.substr(end + 1);
    node = node.substr(1, end - 1);
    if (node.find(':') == std::string_view::npos) return std::nullopt;
  } else if (const size_t colon = node.find(':');
             colon != std::string_view::npos && node.find(':', colon + 1) == node.npos) {
    port = node.substr(colon);
    node = node.substr(0, colon);
  }
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  if (!port.empty() &&
      (port.size() < 2 || port.front() != ':' || !std::ranges::all_of(port.substr(1), is_digit))) {
    return std::nullopt;
  }
  return IpAddress::parse(node);
}

/// An item of Forwarded: pairs such as for="[2001:db8::7]:47011";proto=https.
struct ForwardedItem {
  std::optional<IpAddress> address;  ///< no value if "for" is missing, repeated, or not an address
  bool has_tls = false;
};

ForwardedItem parse_forwarded(std::string_view item) {
  ForwardedItem result;
  size_t addresses = 0;
  while (!item.empty()) {
    const std::string_view pair = take_last(item, ';');
    const size_t equals = std::min(pair.find('='), pair.size());
    const std::string_view name = pair.substr(0, equals);
    std::string_view value = pair.substr(std::min(equals + 1, pair.size()));
    if (value.size() >= 2 && value.front() == '"' && value.back() == '"') {
      value = value.substr(1, value.size() - 2);
    }
    if (equals_ignoring_case(name, "for")) {
      result.address = parse_node(value);
      ++addresses;
    } else if (equals_ignoring_case(name, "proto")) {
      result.has_tls = equals_ignoring_case(value, "https");
    }
  }
  if (addresses != 1) result.address.reset();
  return result;
}

}  // namespace

Result<TrustedProxies> TrustedProxies::parse(const std::vector<std::string>& ranges,
                                             ProxyFields fields) {
  TrustedProxies proxies;
  for (const std::string& name : {fields.user, fields.groups}) {
    if (name.empty()) continue;
    const bool is_name = std::ranges::all_of(name, [](char c) {
      return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-';
    });
    if (!is_name) {
      return fail(
          Status::invalid_argument,
          fmt::format("expected the name of a field such as X-Forwarded-User, found '{}'", name));
    }
    if (ranges.empty()) {
      return fail(Status::invalid_argument,
                  fmt::format("{}: expected the address of the proxy that sets it", name));
    }
  }
  proxies.fields_ = std::move(fields);
  for (const std::string& text : ranges) {
    Result<AddressRange> range = AddressRange::parse(text);
    if (!range) return tl::unexpected(range.error());
    proxies.ranges_.push_back(*range);
  }
  return proxies;
}

bool TrustedProxies::trusts(const IpAddress& address) const {
  return std::ranges::any_of(ranges_,
                             [&](const AddressRange& range) { return range.contains(address); });
}

TrustedProxies::Client TrustedProxies::client_of(const IpAddress& peer, std::string_view addresses,
                                                 std::string_view scheme) const {
  Client client{.address = peer, .has_tls = false};
  if (fields_.client == ClientField::proxy_protocol) return client;
  const bool has_scheme = fields_.client == ClientField::x_forwarded_for;
  if (has_scheme && trusts(peer)) {
    client.has_tls = equals_ignoring_case(take_last(scheme, ','), "https");
  }
  while (!addresses.empty() && trusts(client.address)) {
    const std::string_view item = take_last(addresses, ',');
    const ForwardedItem next =
        has_scheme ? ForwardedItem{parse_node(item), client.has_tls} : parse_forwarded(item);
    if (!next.address) break;
    client = {.address = *next.address, .has_tls = next.has_tls};
  }
  return client;
}

}  // namespace isosplat::server
