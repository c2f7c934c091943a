#pragma once

#include <cstdint>

#include "server/message.h"

namespace isosplat {

// Responses to requests above a limit. The caller adds the fields of its OriginPolicy.

/// 429: the address has used up its rate; it may ask again after `seconds`.
Response rate_response(uint32_t seconds);

/// 503: the memory of bodies that are being sent is used up.
Response busy_response();

}  // namespace isosplat
