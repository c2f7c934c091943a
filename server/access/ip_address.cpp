#include "server/access/ip_address.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <charconv>
#include <cstring>

namespace isosplat::server {
namespace {

constexpr std::array<uint8_t, 12> kMapped = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xff, 0xff};

IpAddress mapped(const void* v4) {
  IpAddress address;
  std::ranges::copy(kMapped, address.bytes.begin());
  std::memcpy(address.bytes.data() + kMapped.size(), v4, 4);
  return address;
}

/// Clears the bits behind the first `prefix` ones.
IpAddress network_of(IpAddress address, unsigned prefix) {
  for (unsigned i = 0; i < address.bytes.size(); ++i) {
    const unsigned kept = std::clamp(prefix, 8 * i, 8 * i + 8) - 8 * i;
    address.bytes[i] = static_cast<uint8_t>(address.bytes[i] & (0xff00u >> kept));
  }
  return address;
}

}  // namespace

std::optional<IpAddress> IpAddress::parse(std::string_view text) {
  char copy[INET6_ADDRSTRLEN] = {};  // inet_pton needs a zero at the end
  if (text.size() >= sizeof copy || text.find('\0') != std::string_view::npos) return std::nullopt;
  text.copy(copy, text.size());
  IpAddress address;
  if (::inet_pton(AF_INET6, copy, address.bytes.data()) == 1) return address;
  in_addr v4{};
  if (::inet_pton(AF_INET, copy, &v4) == 1) return mapped(&v4);
  return std::nullopt;
}

std::optional<IpAddress> IpAddress::of(const sockaddr& address) {
  if (address.sa_family == AF_INET) {
    return mapped(&reinterpret_cast<const sockaddr_in&>(address).sin_addr);
  }
  if (address.sa_family != AF_INET6) return std::nullopt;
  IpAddress v6;
  std::memcpy(v6.bytes.data(), &reinterpret_cast<const sockaddr_in6&>(address).sin6_addr, 16);
  return v6;
}

bool IpAddress::is_v4() const {
  return std::equal(kMapped.begin(), kMapped.end(), bytes.begin());
}

bool IpAddress::is_loopback() const {
  constexpr std::array<uint8_t, 16> kV6 = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1};
  return bytes == kV6 || (is_v4() && bytes[12] == 127);
}

std::string IpAddress::text() const {
  char buffer[INET6_ADDRSTRLEN] = {};
  if (is_v4()) {
    ::inet_ntop(AF_INET, bytes.data() + kMapped.size(), buffer, sizeof buffer);
  } else {
    ::inet_ntop(AF_INET6, bytes.data(), buffer, sizeof buffer);
  }
  return buffer;
}

std::string IpAddress::client_key() const {
  return is_v4() || is_loopback() ? text() : network_of(*this, 64).text();
}

Result<AddressRange> AddressRange::parse(std::string_view text) {
  const auto wrong = [&](std::string_view expected) {
    return fail(Status::invalid_argument, fmt::format("expected {}, found '{}'", expected, text));
  };
  const size_t slash = std::min(text.find('/'), text.size());
  const std::optional<IpAddress> address = IpAddress::parse(text.substr(0, slash));
  constexpr std::string_view kExpected = "addresses such as 192.0.2.7, 10.0.0.0/8 or 2001:db8::/32";
  if (!address) return wrong(kExpected);
  AddressRange range;
  range.first_ = *address;
  if (slash == text.size()) return range;
  // A prefix of the mapped form, such as ::ffff:10.0.0.0/104, has the bits of IPv6.
  const bool is_v4_notation = text.find(':') == std::string_view::npos;
  const unsigned most = is_v4_notation ? 32 : 128;
  const std::string_view digits = text.substr(slash + 1);
  unsigned bits = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), bits);
  if (error != std::errc() || end != digits.data() + digits.size() || bits > most) {
    return wrong(kExpected);
  }
  range.prefix_ = is_v4_notation ? bits + 96 : bits;
  const IpAddress network = network_of(*address, range.prefix_);
  if (network != *address) return wrong(fmt::format("{}/{}", network.text(), bits));
  return range;
}

bool AddressRange::contains(const IpAddress& address) const {
  return network_of(address, prefix_) == first_;
}

}  // namespace isosplat::server
