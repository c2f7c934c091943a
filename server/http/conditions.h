#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "server/http/message.h"

namespace isosplat::server {

/// A strong ETag of these bytes (their XXH3-128), with its quotes.
std::string etag_for(std::string_view bytes);

/// Whether an If-None-Match or If-Match field contains `etag` (with its quotes), by weak or strong
/// comparison. "*" matches every ETag; a malformed list matches none.
bool names_etag(std::string_view field, std::string_view etag, bool weak);

/// A byte range [first, last]; both ends are inclusive, as in HTTP.
struct ByteRange {
  uint64_t first = 0;
  uint64_t last = 0;
};

enum class RangeKind {
  whole,          ///< no Range field, or one to ignore: malformed, another unit, several ranges
  part,           ///< the range in `range`
  unsatisfiable,  ///< begins past the end, or selects the last 0 bytes
};

struct ParsedRange {
  RangeKind kind = RangeKind::whole;
  ByteRange range;
};

/// Parses a Range field for a resource of `size` bytes (RFC 9110, section 14). Numbers above 64
/// bits are beyond the end.
ParsedRange parse_range(std::string_view field, uint64_t size);

/// The requested byte range. Range applies only to GET, and only if If-Range is absent or equals
/// the ETag.
ParsedRange requested_range(const Request& request, std::string_view etag, uint64_t size);

enum class CachePolicy : uint8_t {
  revalidated,  ///< may change at any time
  immutable,    ///< never changes under its URL
};

/// Begins the response for a resource with this ETag: sets ETag and Cache-Control, and evaluates
/// If-Match (412) and If-None-Match (304) as in RFC 9110, section 13.2.2. `is_private`: only the
/// client's own cache may keep the response.
Response begin_response(const Request& request, const std::string& etag, CachePolicy policy,
                        bool is_private);

/// Whether the response of begin_response() is complete (304 or 412): do not add a body.
bool is_complete(const Response& response);

enum class Encoding : uint8_t { identity, gzip, brotli };

/// Whether an Accept-Encoding field admits gzip or brotli, by name or by "*". q=0 excludes.
bool accepts_encoding(std::string_view field, Encoding encoding);

}  // namespace isosplat::server
