#include "server/refusals.h"

#include <fmt/format.h>

#include <string>

namespace isosplat {

Response rate_response(uint32_t seconds) {
  Response response =
      error_response(429, "too_many_requests",
                     fmt::format("this address has used up its rate: try again in {} s", seconds));
  response.set("Retry-After", std::to_string(seconds));
  response.set("X-Content-Type-Options", "nosniff");
  return response;
}

Response busy_response(std::string_view message) {
  Response response = error_response(503, "busy", message);
  response.set("Retry-After", "1");
  response.set("X-Content-Type-Options", "nosniff");
  return response;
}

}  // namespace isosplat
