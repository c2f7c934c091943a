#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "server/message.h"

namespace isosplat {

/// A strong ETag, with its quotes, that differs for other bytes.
std::string etag_for(std::string_view bytes);

/// Whether an If-None-Match or If-Match field names `etag` (with its quotes): by weak comparison
/// where `weak`, else strong. "*" names every one. A malformed list names none.
bool names_etag(std::string_view field, std::string_view etag, bool weak);

/// A run of bytes of a resource: [first, last], both inclusive as in HTTP.
struct ByteRange {
  uint64_t first = 0;
  uint64_t last = 0;
};

enum class RangeKind {
  whole,  ///< no Range, or one that is to be ignored: malformed, another unit, several ranges
  part,   ///< the range in `range`
  unsatisfiable,  ///< begins past the end, or asks for the last 0 bytes
};

struct RangeAnswer {
  RangeKind kind = RangeKind::whole;
  ByteRange range;
};

/// Reads a Range field for a resource of `size` bytes (RFC 9110, section 14). Numbers that overflow
/// 64 bits count as beyond the end.
RangeAnswer parse_range(std::string_view field, uint64_t size);

/// The part of a resource that the request asks for: of its Range where the method is GET and
/// If-Range, if there is one, names the very ETag.
RangeAnswer requested_range(const Request& request, std::string_view etag, uint64_t size);

enum class CachePolicy : uint8_t {
  revalidated,  ///< may change at any time
  immutable,    ///< never changes under its URL
};

/// Begins the answer about a resource with this ETag: with the fields ETag and Cache-Control, or
/// with status 304 or 412 as If-Match and If-None-Match demand (RFC 9110, section 13.2.2).
Response begin_answer(const Request& request, const std::string& etag, CachePolicy policy);

/// Whether begin_answer() has said all: the answer gets no body.
bool is_answered(const Response& response);

enum class Encoding : uint8_t { identity, gzip, brotli };

/// Whether an Accept-Encoding field admits the encoding (not identity). "*" counts; q=0 excludes.
bool accepts_encoding(std::string_view field, Encoding encoding);

}  // namespace isosplat
