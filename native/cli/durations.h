#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace isosplat::cli {

/// "90s", "30m", "12h", "7d" as seconds: 1 s to 3650 d. No value if malformed.
std::optional<int64_t> parse_duration(std::string_view text);

}  // namespace isosplat::cli
