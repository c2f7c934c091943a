#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

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

enum class Encoding : uint8_t { identity, gzip, brotli };

/// Whether an Accept-Encoding field admits the encoding (not identity). "*" counts; q=0 excludes.
bool accepts_encoding(std::string_view field, Encoding encoding);

}  // namespace isosplat
