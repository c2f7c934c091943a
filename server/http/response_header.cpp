#include "server/http/response_header.h"

#include <fmt/format.h>

#include <ctime>
#include <string_view>

namespace isosplat::server {
namespace {

/// The value of the Date field (RFC 9110, 5.6.7), formatted once a second on each thread.
std::string_view http_date() {
  thread_local std::time_t formatted = -1;
  thread_local std::string text;
  const std::time_t now = std::time(nullptr);
  if (now != formatted) {
    std::tm parts{};
    ::gmtime_r(&now, &parts);
    // strftime would use the names of the process's locale.
    constexpr const char* kDays[] = {"Sun", "Mon", "Tue", "Wed", "Thu", "Fri", "Sat"};
    constexpr const char* kMonths[] = {"Jan", "Feb", "Mar", "Apr", "May", "Jun",
                                       "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"};
    text = fmt::format("{}, {:02} {} {:04} {:02}:{:02}:{:02} GMT", kDays[parts.tm_wday],
                       parts.tm_mday, kMonths[parts.tm_mon], parts.tm_year + 1900, parts.tm_hour,
                       parts.tm_min, parts.tm_sec);
    formatted = now;
  }
  return text;
}

}  // namespace

std::string response_header(const Response& response, bool close, bool http_1_0) {
  std::string text;
  text.reserve(200 + response.headers.size());
  const auto append_number = [&text](uint64_t number) {
    const fmt::format_int digits(number);
    text.append(digits.data(), digits.size());
  };
  text += "HTTP/1.1 ";
  append_number(static_cast<uint64_t>(response.status));
  (text += ' ') += reason_phrase(response.status);
  (text += "\r\nDate: ") += http_date();
  text += "\r\nServer: isosplat\r\n";
  if (response.status != 204 && response.status != 304) {
    text += "Content-Length: ";
    append_number(response.body_size());
    text += "\r\n";
  }
  if (close) {
    text += "Connection: close\r\n";
  } else if (http_1_0) {
    text += "Connection: keep-alive\r\n";
  }
  text += response.headers;
  text += "\r\n";
  return text;
}

}  // namespace isosplat::server
