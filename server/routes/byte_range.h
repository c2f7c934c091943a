#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "server/http/conditions.h"
#include "server/http/message.h"

namespace isosplat::server {

/// The bytes of a file that a response sends.
struct SentBytes {
  uint64_t first = 0;
  uint64_t bytes = 0;
};

/// Evaluates the Range field of a request for a file of `size` bytes: sets status and fields of
/// `response`, and returns the range to send. If the range lies beyond the end, `response` becomes
/// 416, and nothing is returned.
std::optional<SentBytes> begin_range(const Request& request, std::string_view etag, uint64_t size,
                                     Response& response);

}  // namespace isosplat::server
