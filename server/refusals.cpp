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

Response busy_response() {
  Response response = error_response(
      503, "busy", "the server is sending as much as it has memory for: try again in a second");
  response.set("Retry-After", "1");
  response.set("X-Content-Type-Options", "nosniff");
  return response;
}

}  // namespace isosplat
