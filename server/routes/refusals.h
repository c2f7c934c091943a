#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "server/http/message.h"
#include "server/log/access_log.h"

namespace isosplat::server {

// Responses to requests above a limit. The caller adds the fields of its OriginPolicy.

/// 429: the client has used up its rate. It may send another request after `seconds`.
Response rate_response(uint32_t seconds);

/// 503: other requests use up a resource at this time, which the message names.
Response busy_response(std::string_view message);

/// The line of the access log for a connection that was refused before its request was read.
/// `status`: 0 if it was closed without a response. `bytes`: bytes of the body that were sent.
std::string refusal_line(LogFormat format, std::string_view address, int status, uint64_t bytes);

}  // namespace isosplat::server
