#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>

namespace isosplat::server {

/// The formats of a line of the access log. HTTP.md shows an example of each.
enum class LogFormat : uint8_t {
  plain,   ///< address, method, target, status, bytes, milliseconds
  common,  ///< the common log format of web servers, and the request's id
  json     ///< one object
};

/// A response, for the access log. Views are as sent by the client.
struct AccessEntry {
  std::chrono::system_clock::time_point time;  ///< when the request was complete
  std::string_view id;                         ///< request_id()
  std::string_view address;                    ///< IPv6: the /64 network
  std::string_view client;  ///< Grant::client(): the client's name; empty: unknown
  std::string_view method;
  std::string_view target;
  std::string_view route;  ///< its pattern; empty if the request had none
  bool is_http_1_0 = false;
  int status = 0;      ///< 0: the connection was closed without a response
  uint64_t bytes = 0;  ///< bytes of the body that were sent
  std::chrono::nanoseconds duration{0};
};

/// One line without a line break. Text of the client is printable ASCII, with escapes \xNN for all
/// other bytes; tokens and signatures are replaced (without_secrets). Header fields are not logged.
std::string access_line(const AccessEntry& entry, LogFormat format);

/// The id of a request: `given` if it has 1 to kMaxRequestId letters, digits, "-", "_" and ".";
/// otherwise 16 hexadecimal digits that are unique in this process.
std::string request_id(std::string_view given);
bool is_request_id(std::string_view given);
inline constexpr size_t kMaxRequestId = 64;

}  // namespace isosplat::server
