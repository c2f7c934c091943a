#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace isosplat::server {

/// Length of the UTF-8 sequence at the beginning of `text` (not empty); 0 if it is invalid.
size_t utf8_length(std::string_view text);

/// Escapes text for one line of a log or a terminal. Each byte that could end the line, control the
/// terminal or change the direction of the text becomes \xNN: control characters, bytes that are
/// not UTF-8, U+2028 to U+202E, U+2066 to U+2069, and the backslash.
std::string printable_text(std::string_view text);

}  // namespace isosplat::server
