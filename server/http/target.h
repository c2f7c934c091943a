#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "shared/core/base/status.h"
#include "shared/core/grid/grid.h"
#include "shared/system/store_file/store_file.h"

namespace isosplat::server {

/// The decoded target of a request. "/v1/volumes/engine?x=1" has the segments v1, volumes, engine
/// and the query x=1. If the path ends in "/", the last segment is empty; "/" is one empty segment.
struct Target {
  std::vector<std::string> segments;
  std::vector<std::pair<std::string, std::string>> query;

  /// The decoded path: the segments, each after a "/".
  std::string path() const;

  /// The value of the first parameter of this name in the query.
  std::optional<std::string_view> parameter(std::string_view name) const;
};

/// Parses origin form ("/path?query") and absolute form ("http://host/path?query").
///
/// Errors (invalid_argument): a character that is not allowed in a target; a fragment; "%" without
/// two hexadecimal digits; an escaped "/", "\" or control character; and the segments "." and "..",
/// escaped or not, which clients must resolve. "+" is not decoded. Each resource has one URL, so
/// that caches keep one copy of it. Therefore an escaped letter or digit in a path or in the query
/// of data is an error as well, and so is an empty item in the query of data. The page's program
/// interprets the query of the page: items that cannot be decoded are omitted.
Result<Target> parse_target(std::string_view raw);

/// Whether a target belongs to the data interface; all other targets belong to the page.
bool is_data(const Target& target);

/// Text of a client for an error message: in quotes, shortened to 40 bytes.
std::string quoted(std::string_view text);

/// A decimal number of at most `max`, without sign, leading zero or other characters. Each number
/// has one spelling, so that each resource has one URL.
std::optional<uint32_t> parse_index(std::string_view text, uint32_t max = UINT32_MAX);

/// "x.y.z", each a parse_index() of at most kMaxVoxelsPerAxis.
std::optional<Index3> parse_block(std::string_view text);

/// A finite decimal number: "60.5", "-1000", "1e3", "1e+3".
std::optional<double> parse_value(std::string_view text);

/// "a..b" with a ≤ b, or one number for both. In the units of the volume.
struct ValueRange {
  double low = 0;
  double high = 0;
};
std::optional<ValueRange> parse_value_range(std::string_view text);

/// Six decimal numbers "x,y,z,x,y,z".
std::optional<std::array<double, 6>> parse_box(std::string_view text);

/// "x.y.z,x.y.z,…". Errors (invalid_argument) name the item.
Result<std::vector<Index3>> parse_blocks(std::string_view text);

/// Chunks, each "level/x.y.z/band": "0/1.2.3/4,1/0.0.0/2,…". Errors (invalid_argument) name the
/// item.
Result<std::vector<ChunkAddress>> parse_chunks(std::string_view text);

}  // namespace isosplat::server
