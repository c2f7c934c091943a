#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "shared/base/status.h"
#include "shared/grid/grid.h"
#include "shared/store_file/store_file.h"

namespace isosplat {

/// A request's target, decoded once. "/v1/volumes/engine?x=1" has the segments v1, volumes, engine
/// and the query x=1. A path that ends in "/" has a last segment that is empty; "/" is one empty
/// segment.
struct Target {
  std::vector<std::string> segments;
  std::vector<std::pair<std::string, std::string>> query;

  /// The path again: the segments, each after a "/".
  std::string path() const;
};

/// Parses origin form ("/path?query") and absolute form ("http://host/path?query").
///
/// Errors (invalid_argument): a character that a target may not hold, a fragment, an escape that is
/// not "%" and two hexadecimal digits, an escaped "/", "\" or control character, and the segments
/// "." and "..", escaped or not: a client resolves those before it asks. "+" stands for itself.
/// Outside of /v1 an item of the query that cannot be decoded is left out: it is the page's.
Result<Target> parse_target(std::string_view raw);

/// A decimal number without sign, leading zero or anything beside it, at most `max`. One spelling
/// per number means one URL per resource.
std::optional<uint32_t> parse_index(std::string_view text, uint32_t max = UINT32_MAX);

/// "x.y.z", each a parse_index() of at most kMaxVoxelsPerAxis.
std::optional<Index3> parse_block(std::string_view text);

/// A finite decimal number: "60.5", "-1000", "1e3", "1e+3".
std::optional<double> parse_value(std::string_view text);

/// "a..b" with a ≤ b, or one number for both. In the volume's own values.
struct ValueRange {
  double low = 0;
  double high = 0;
};
std::optional<ValueRange> parse_value_range(std::string_view text);

/// "x.y.z,x.y.z,…". Errors (invalid_argument) name the item.
Result<std::vector<Index3>> parse_blocks(std::string_view text);

/// Chunks, each "level/x.y.z/band": "0/1.2.3/4,1/0.0.0/2,…". Errors (invalid_argument) name the
/// item.
Result<std::vector<ChunkAddress>> parse_chunks(std::string_view text);

}  // namespace isosplat
