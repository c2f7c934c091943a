#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "shared/core/base/status.h"

struct sockaddr;

namespace isosplat::server {

/// An IPv4 or IPv6 address. IPv4 addresses are stored as IPv6-mapped ones (::ffff:a.b.c.d), so that
/// both forms of an address are equal.
struct IpAddress {
  std::array<uint8_t, 16> bytes{};

  /// Parses "192.0.2.7" or "2001:db8::7", without brackets, port and zone. No value if malformed.
  static std::optional<IpAddress> parse(std::string_view text);

  /// The address of a socket of IPv4 or IPv6. No value for other families.
  static std::optional<IpAddress> of(const sockaddr& address);

  bool is_v4() const;
  bool is_loopback() const;  ///< 127.0.0.0/8 or ::1

  std::string text() const;

  /// The key by which limits, rates and logs identify a client: an IPv4 address, or the /64 network
  /// of an IPv6 address, which usually belongs to one subscriber.
  std::string client_key() const;

  friend bool operator==(const IpAddress&, const IpAddress&) = default;
};

/// A range of addresses in the notation of CIDR: "10.0.0.0/8", "2001:db8::/32", or one address.
class AddressRange {
 public:
  /// Errors (invalid_argument): malformed, or with bits beyond the prefix ("10.0.0.1/8").
  static Result<AddressRange> parse(std::string_view text);

  bool contains(const IpAddress& address) const;

 private:
  IpAddress first_;
  unsigned prefix_ = 128;  ///< bits; of IPv4 with the 96 of the mapped form
};

}  // namespace isosplat::server
