#include "server/access/proxy_header.h"

#include <algorithm>
#include <charconv>
#include <cstring>
#include <string>

namespace isosplat::server {
namespace {

using State = ProxyHeader::State;

constexpr std::string_view kSignature2("\r\n\r\n\0\r\nQUIT\n", 12);
constexpr std::string_view kSignature1 = "PROXY ";

/// Whether one of the texts begins with the other.
bool agree(std::string_view a, std::string_view b) {
  const size_t common = std::min(a.size(), b.size());
  return a.substr(0, common) == b.substr(0, common);
}

ProxyHeader malformed() {
  return {.state = State::malformed, .bytes = 0, .source = std::nullopt, .is_local = false};
}

std::string_view take_word(std::string_view& text) {
  const std::string_view word = text.substr(0, text.find(' '));
  text.remove_prefix(std::min(word.size() + 1, text.size()));
  return word;
}

bool is_port(std::string_view text) {
  unsigned port = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), port);
  return error == std::errc() && end == text.data() + text.size() && port <= 65535 &&
         (text.size() == 1 || text.front() != '0');
}

ProxyHeader parse_version_1(std::string_view received) {
  constexpr size_t kMaxLine = 107;
  const size_t end = received.substr(0, kMaxLine).find("\r\n");
  if (end == std::string_view::npos) {
    return received.size() < kMaxLine ? ProxyHeader{} : malformed();
  }
  ProxyHeader header;
  header.state = State::complete;
  header.bytes = end + 2;
  std::string_view rest = received.substr(kSignature1.size(), end - kSignature1.size());
  const std::string_view family = take_word(rest);
  if (family == "UNKNOWN") return header;  // the rest is ignored
  if (family != "TCP4" && family != "TCP6") return malformed();
  const auto source = IpAddress::parse(take_word(rest));
  const auto destination = IpAddress::parse(take_word(rest));
  const bool has_ports = is_port(take_word(rest)) && is_port(rest);
  const bool is_v4 = family == "TCP4";
  // TCP6 also admits IPv4-mapped addresses.
  if (!source || !destination || !has_ports ||
      (is_v4 && !(source->is_v4() && destination->is_v4()))) {
    return malformed();
  }
  header.source = source;
  return header;
}

ProxyHeader parse_version_2(std::string_view received) {
  constexpr size_t kFixedBytes = 16;
  if (received.size() < kFixedBytes) return {};
  const auto byte = [&](size_t at) { return static_cast<unsigned char>(received[at]); };
  const unsigned version = byte(12) >> 4, command = byte(12) & 15;
  const unsigned family = byte(13) >> 4, protocol = byte(13) & 15;
  const size_t length = size_t{byte(14)} << 8 | byte(15);
  if (version != 2 || command > 1 || kFixedBytes + length > kMaxProxyHeader) return malformed();
  if (received.size() < kFixedBytes + length) return {};
  ProxyHeader header;
  header.state = State::complete;
  header.bytes = kFixedBytes + length;
  header.is_local = command == 0;
  if (header.is_local) return header;                    // the rest is ignored
  constexpr unsigned kInet = 1, kUnix = 3, kStream = 1;  // 0: unspecified; family 2: IPv6
  if (family > kUnix || protocol > kStream) return malformed();
  if (family == 0 || family == kUnix || protocol != kStream) return header;
  const size_t address_bytes = family == kInet ? 4 : 16;
  if (length < 2 * address_bytes + 4) return malformed();
  IpAddress source;
  if (family == kInet) source.bytes[10] = source.bytes[11] = 0xff;
  std::memcpy(source.bytes.data() + 16 - address_bytes, received.data() + kFixedBytes,
              address_bytes);
  header.source = source;
  return header;
}

}  // namespace

ProxyHeader parse_proxy_header(std::string_view received) {
  if (received.starts_with(kSignature2)) return parse_version_2(received);
  if (received.starts_with(kSignature1)) return parse_version_1(received);
  return agree(received, kSignature1) || agree(received, kSignature2) ? ProxyHeader{} : malformed();
}

}  // namespace isosplat::server
