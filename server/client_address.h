#pragma once

#include <boost/asio/ip/address.hpp>
#include <string>

namespace isosplat {

/// The key for counting connections and rates: an IPv4 address, or the first 64 bits of an IPv6
/// address, since a client usually has a whole /64 network.
std::string address_key(const boost::asio::ip::address& address);

}  // namespace isosplat
