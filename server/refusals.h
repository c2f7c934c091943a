#pragma once

#include <cstdint>
#include <string_view>

#include "server/message.h"

namespace isosplat {

// Responses to requests above a limit. The caller adds the fields of its OriginPolicy.

/// 429: the address has used up its rate; it may ask again after `seconds`.
Response rate_response(uint32_t seconds);

/// 503: something that other requests use at the moment is used up, as the message says.
Response busy_response(std::string_view message);

}  // namespace isosplat
