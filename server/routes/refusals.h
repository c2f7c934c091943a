#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "server/http/message.h"
#include "server/log/access_log.h"

namespace isosplat::server {

// Responses to requests above a limit. The caller adds the fields of its OriginPolicy.

/// 429: the client has used up its rate; it may ask again after `seconds`.
Response rate_response(uint32_t seconds);

/// 503: something that other requests use at the moment is used up, as the message says.
Response busy_response(std::string_view message);

/// The line of the access log for a connection that was refused before it had sent a request.
/// `status`: 0 if it was closed without a response. `bytes`: of the body, as far as they were sent.
std::string refusal_line(LogFormat format, std::string_view address, int status, uint64_t bytes);

}  // namespace isosplat::server
