#include "server/routes/byte_range.h"

#include <fmt/format.h>

#include <string>

namespace isosplat::server {

std::optional<SentBytes> begin_range(const Request& request, std::string_view etag, uint64_t size,
                                     Response& response) {
  const ParsedRange range = requested_range(request, std::string(etag), size);
  if (range.kind == RangeKind::unsatisfiable) {
    response = error_response(
        416, "range_not_satisfiable",
        fmt::format("expected a range within {} bytes, found one beyond the end", size));
    response.set("Content-Range", fmt::format("bytes */{}", size));
    response.set("Accept-Ranges", "bytes");
    return std::nullopt;
  }
  response.set("Content-Type", "application/octet-stream");
  response.set("Accept-Ranges", "bytes");
  if (range.kind != RangeKind::part) return SentBytes{0, size};
  const auto [first, last] = range.range;
  response.status = 206;
  response.set("Content-Range", fmt::format("bytes {}-{}/{}", first, last, size));
  return SentBytes{first, last - first + 1};
}

}  // namespace isosplat::server
