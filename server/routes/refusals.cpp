#include "server/routes/refusals.h"

#include <fmt/format.h>

#include <chrono>
#include <string>

namespace isosplat::server {

Response rate_response(uint32_t seconds) {
  Response response =
      error_response(429, "too_many_requests",
                     fmt::format("this client has used up its rate: try again in {} s", seconds));
  response.set("Retry-After", std::to_string(seconds));
  return response;
}

Response busy_response(std::string_view message) {
  Response response = error_response(503, "busy", message);
  response.set("Retry-After", "1");
  return response;
}

std::string refusal_line(LogFormat format, std::string_view address, int status, uint64_t bytes) {
  const std::string id = request_id({});
  AccessEntry entry;
  entry.time = std::chrono::system_clock::now();
  entry.id = id;
  entry.address = address;
  entry.status = status;
  entry.bytes = bytes;
  return access_line(entry, format);
}

}  // namespace isosplat::server
