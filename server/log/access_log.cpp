#include "server/log/access_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <ctime>
#include <random>

#include "server/access/credentials.h"
#include "server/http/message.h"

namespace isosplat::server {
namespace {

std::string printable(std::string_view text) {
  std::string result;
  for (const char c : text) {
    if (c > 0x20 && c < 0x7f && c != '"' && c != '\\') {
      result += c;
    } else {
      result += fmt::format("\\x{:02x}", static_cast<unsigned char>(c));
    }
  }
  return result;
}

/// UTC. strftime would use the names of the process's locale.
std::tm utc(std::chrono::system_clock::time_point time) {
  const std::time_t seconds =
      std::chrono::system_clock::to_time_t(std::chrono::floor<std::chrono::seconds>(time));
  std::tm parts{};
  ::gmtime_r(&seconds, &parts);
  return parts;
}

/// "22/Nov/2026:22:10:00 +0000"
std::string common_time(std::chrono::system_clock::time_point time) {
  constexpr const char* kMonths[] = {"Jan", "Feb", "Mar", "Apr", "May", "Jun",
                                     "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"};
  const std::tm parts = utc(time);
  return fmt::format("{:02}/{}/{}:{:02}:{:02}:{:02} +0000", parts.tm_mday, kMonths[parts.tm_mon],
                     parts.tm_year + 1900, parts.tm_hour, parts.tm_min, parts.tm_sec);
}

/// "2026-11-22T22:10:00.123Z" (RFC 3339)
std::string rfc3339_time(std::chrono::system_clock::time_point time) {
  const std::tm parts = utc(time);
  const auto milliseconds =
      std::chrono::floor<std::chrono::milliseconds>(time.time_since_epoch()).count() % 1000;
  return fmt::format("{}-{:02}-{:02}T{:02}:{:02}:{:02}.{:03}Z", parts.tm_year + 1900,
                     parts.tm_mon + 1, parts.tm_mday, parts.tm_hour, parts.tm_min, parts.tm_sec,
                     milliseconds);
}

}  // namespace

std::string access_line(const AccessEntry& entry, LogFormat format) {
  const std::string method = printable(entry.method);
  const std::string client = printable(entry.client);
  const std::string target = printable(without_secrets(entry.target));
  const double milliseconds = std::chrono::duration<double, std::milli>(entry.duration).count();
  switch (format) {
    case LogFormat::common:
      return fmt::format("{} - {} [{}] \"{} {} HTTP/1.{}\" {} {} {}", entry.address,
                         client.empty() ? "-" : client, common_time(entry.time),
                         method.empty() ? "-" : method, target.empty() ? "-" : target,
                         entry.is_http_1_0 ? 0 : 1, entry.status, entry.bytes, entry.id);
    case LogFormat::json:
      return fmt::format(
          "{{\"time\":\"{}\",\"id\":\"{}\",\"address\":{},\"client\":{},\"method\":{},\"target\":{}"
          ",\"route\":{},"
          "\"status\":{},\"bytes\":{},\"ms\":{:.3f}}}",
          rfc3339_time(entry.time), entry.id, json_string(entry.address), json_string(client),
          json_string(method), json_string(target), json_string(entry.route), entry.status,
          entry.bytes, milliseconds);
    case LogFormat::plain:
      break;
  }
  return fmt::format("{} {} {} {} {} {:.0f}ms{}{}", entry.address, method.empty() ? "-" : method,
                     target.empty() ? "-" : target, entry.status, entry.bytes, milliseconds,
                     client.empty() ? "" : " ", client);
}

bool is_request_id(std::string_view given) {
  return !given.empty() && given.size() <= kMaxRequestId && std::ranges::all_of(given, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' ||
           c == '_' || c == '.';
  });
}

std::string request_id(std::string_view given) {
  if (is_request_id(given)) return std::string(given);
  // Ids need not be secret, but must be unique, also across restarts.
  static std::atomic<uint64_t> next{(uint64_t{std::random_device{}()} << 32) |
                                    std::random_device{}()};
  return fmt::format("{:016x}", next.fetch_add(1, std::memory_order_relaxed));
}

}  // namespace isosplat::server
