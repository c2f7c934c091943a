#include "shared/import/text/xml_scanner.h"

#include <charconv>
#include <cstdint>

#include "shared/import/text/header_text.h"

namespace isosplat::import {
namespace {

constexpr std::string_view kSpace = " \t\r\n";

std::string_view without_prefix(std::string_view name) {
  const size_t colon = name.rfind(':');
  return colon == name.npos ? name : name.substr(colon + 1);
}

void append_utf8(uint32_t code, std::string& out) {
  const auto put = [&](uint32_t byte) { out.push_back(static_cast<char>(byte)); };
  const auto tail = [&](int shift) { put(0x80 | (code >> shift & 0x3f)); };
  if (code < 0x80) {
    put(code);
  } else if (code < 0x800) {
    put(0xc0 | code >> 6);
    tail(0);
  } else if (code < 0x10000) {
    put(0xe0 | code >> 12);
    tail(6), tail(0);
  } else {
    put(0xf0 | code >> 18);
    tail(12), tail(6), tail(0);
  }
}

/// The character of an entity's name, such as "amp", "#181" or "#xb5".
std::optional<uint32_t> character_of(std::string_view name) {
  struct Known {
    std::string_view name;
    uint32_t code;
  };
  static constexpr Known kKnown[] = {{"amp", '&'},  {"lt", '<'},    {"gt", '>'},
                                     {"quot", '"'}, {"apos", '\''}, {"micro", 0xb5},
                                     {"mu", 0x3bc}, {"Aring", 0xc5}};
  for (const Known& known : kKnown) {
    if (known.name == name) return known.code;
  }
  if (!name.starts_with('#')) return std::nullopt;
  name.remove_prefix(1);
  const bool is_hex = name.starts_with('x') || name.starts_with('X');
  if (is_hex) name.remove_prefix(1);
  uint32_t code = 0;
  const auto [end, error] =
      std::from_chars(name.data(), name.data() + name.size(), code, is_hex ? 16 : 10);
  if (error != std::errc{} || end != name.data() + name.size() || code == 0 || code > 0x10ffff) {
    return std::nullopt;
  }
  return code;
}

}  // namespace

std::string without_entities(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    const size_t begin = text.find('&');
    out += text.substr(0, begin);
    if (begin == text.npos) break;
    text.remove_prefix(begin);
    const size_t end = text.find(';');
    const auto code = end == text.npos ? std::nullopt : character_of(text.substr(1, end - 1));
    if (code) append_utf8(*code, out);
    if (!code) out.push_back('&');
    text.remove_prefix(code ? end + 1 : 1);
  }
  return out;
}

std::optional<std::string> XmlTag::attribute(std::string_view wanted) const {
  std::string_view rest = attributes;
  for (;;) {
    const size_t equals = rest.find('=');
    if (equals == rest.npos) return std::nullopt;
    const std::string_view found = without_prefix(trimmed(rest.substr(0, equals)));
    rest.remove_prefix(equals + 1);
    const size_t quote = rest.find_first_not_of(kSpace);
    if (quote == rest.npos || (rest[quote] != '"' && rest[quote] != '\'')) return std::nullopt;
    const size_t end = rest.find(rest[quote], quote + 1);
    if (end == rest.npos) return std::nullopt;
    if (found == wanted) return without_entities(rest.substr(quote + 1, end - quote - 1));
    rest.remove_prefix(end + 1);
  }
}

std::optional<XmlTag> XmlScanner::next() {
  for (;;) {
    const size_t begin = text_.find('<', at_);
    if (begin == text_.npos) return std::nullopt;
    const std::string_view rest = text_.substr(begin);
    std::string_view closing;
    if (rest.starts_with("<!--")) closing = "-->";
    if (rest.starts_with("<![CDATA[")) closing = "]]>";
    if (rest.starts_with("<?")) closing = "?>";
    if (closing.empty() && rest.starts_with("<!")) closing = ">";
    if (!closing.empty()) {
      const size_t end = text_.find(closing, begin);
      if (end == text_.npos) return std::nullopt;
      at_ = end + closing.size();
      continue;
    }
    // A ">" in quotes does not end the tag.
    size_t end = begin + 1;
    for (char quote = 0; end < text_.size() && (quote != 0 || text_[end] != '>'); ++end) {
      const char c = text_[end];
      if (quote == 0 && (c == '"' || c == '\'')) {
        quote = c;
      } else if (c == quote) {
        quote = 0;
      }
    }
    if (end >= text_.size()) return std::nullopt;
    at_ = end + 1;
    std::string_view inside = text_.substr(begin + 1, end - begin - 1);
    XmlTag tag;
    tag.ends = inside.starts_with('/') || inside.ends_with('/');
    tag.begins = !inside.starts_with('/');
    if (inside.starts_with('/')) inside.remove_prefix(1);
    if (inside.ends_with('/')) inside.remove_suffix(1);
    const size_t name = std::min(inside.find_first_of(kSpace), inside.size());
    tag.name = without_prefix(inside.substr(0, name));
    tag.attributes = inside.substr(name);
    return tag;
  }
}

std::string XmlScanner::content() const {
  return without_entities(trimmed(text_.substr(at_, text_.find('<', at_) - at_)));
}

}  // namespace isosplat::import
