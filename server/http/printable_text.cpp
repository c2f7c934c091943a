#include "server/http/printable_text.h"

#include <fmt/format.h>

#include <algorithm>

namespace isosplat::server {
namespace {

/// Whether the first `length` bytes of a text are one character that may appear unescaped in a
/// line.
bool is_printable(std::string_view text, size_t length) {
  const auto byte = [&](size_t i) { return static_cast<unsigned char>(text[i]); };
  switch (length) {
    case 0:
      return false;
    case 1:
      return byte(0) >= 0x20 && byte(0) != 0x7f && byte(0) != '\\';
    case 2:
      return byte(0) != 0xc2 || byte(1) >= 0xa0;  // U+0080 to U+009F
    case 3: {
      const bool is_general_punctuation = byte(0) == 0xe2 && byte(1) == 0x80;
      const bool is_isolate = byte(0) == 0xe2 && byte(1) == 0x81;
      return !(is_general_punctuation && byte(2) >= 0xa8 && byte(2) <= 0xae) &&
             !(is_isolate && byte(2) >= 0xa6 && byte(2) <= 0xa9);
    }
    default:
      return true;
  }
}

}  // namespace

size_t utf8_length(std::string_view text) {
  const auto byte = [&](size_t i) { return static_cast<unsigned char>(text[i]); };
  const auto continues = [&](size_t from, size_t to) {
    if (text.size() < to) return false;
    for (size_t i = from; i < to; ++i) {
      if ((byte(i) & 0xc0) != 0x80) return false;
    }
    return true;
  };
  const unsigned char first = byte(0);
  if (first < 0x80) return 1;
  if (first >= 0xc2 && first <= 0xdf) return continues(1, 2) ? 2 : 0;
  if (first >= 0xe0 && first <= 0xef) {
    if (!continues(1, 3)) return 0;
    if (first == 0xe0 && byte(1) < 0xa0) return 0;
    if (first == 0xed && byte(1) > 0x9f) return 0;
    return 3;
  }
  if (first >= 0xf0 && first <= 0xf4) {
    if (!continues(1, 4)) return 0;
    if (first == 0xf0 && byte(1) < 0x90) return 0;
    if (first == 0xf4 && byte(1) > 0x8f) return 0;
    return 4;
  }
  return 0;
}

std::string printable_text(std::string_view text) {
  std::string result;
  result.reserve(text.size());
  while (!text.empty()) {
    const size_t length = utf8_length(text);
    const std::string_view character = text.substr(0, std::max<size_t>(length, 1));
    if (is_printable(text, length)) {
      result += character;
    } else {
      for (const char c : character) result += fmt::format("\\x{:02x}", static_cast<uint8_t>(c));
    }
    text.remove_prefix(character.size());
  }
  return result;
}

}  // namespace isosplat::server
