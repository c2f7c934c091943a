#include "server/http/target.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

namespace isosplat::server {
namespace {

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

/// Whether "%2F" is allowed. In a path it would change the segments. In a query it is allowed,
/// since encodeURIComponent escapes the slashes of "0/1.2.3/4".
enum class EscapedSlash { refused, allowed };

/// Whether letters and digits may be escaped. No client needs this, and each choice of escapes
/// would be another URL of the same resource, so that caches would keep another copy.
enum class EscapedLetters { refused, allowed };

bool is_letter_or_digit(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
}

Result<std::string> decode(std::string_view raw, EscapedSlash slash, EscapedLetters letters) {
  if (raw.find('%') == std::string_view::npos) return std::string(raw);
  std::string text;
  text.reserve(raw.size());
  for (size_t i = 0; i < raw.size(); ++i) {
    if (raw[i] != '%') {
      text += raw[i];
      continue;
    }
    const int high = i + 2 < raw.size() ? hex_digit(raw[i + 1]) : -1;
    const int low = i + 2 < raw.size() ? hex_digit(raw[i + 2]) : -1;
    if (high < 0 || low < 0) {
      return fail(Status::invalid_argument,
                  "target: expected two hexadecimal digits after \"%\": escape \"%\" as \"%25\"");
    }
    const char c = static_cast<char>(high * 16 + low);
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f || c == '\\' ||
        (c == '/' && slash == EscapedSlash::refused)) {
      return fail(Status::invalid_argument,
                  "target: expected no escaped control character, \"/\" or \"\\\": no name "
                  "contains one");
    }
    if (letters == EscapedLetters::refused && is_letter_or_digit(c)) {
      return fail(Status::invalid_argument,
                  fmt::format("target: expected \"{}\" as it is, found it escaped", c));
    }
    text += c;
    i += 2;
  }
  return text;
}

/// The characters that RFC 3986 allows in a path or query, and those that browsers do not escape.
constexpr auto kTargetCharacters = [] {
  std::array<bool, 256> allowed{};
  for (int c = 0x21; c < 0x7f; ++c) {
    allowed[static_cast<size_t>(c)] = c != '#' && c != '\\' && c != '"' && c != '<' && c != '>';
  }
  return allowed;
}();

bool is_target_character(char c) {
  return kTargetCharacters[static_cast<unsigned char>(c)];
}

template <class Item, class Parse>
Result<std::vector<Item>> parse_list(std::string_view text, const char* what, Parse parse) {
  std::vector<Item> items;
  while (true) {
    const size_t comma = text.find(',');
    const std::string_view item = text.substr(0, comma);
    const std::optional<Item> parsed = parse(item);
    if (!parsed) {
      return fail(
          Status::invalid_argument,
          fmt::format("expected a list of {} separated by commas, found {}", what, quoted(item)));
    }
    items.push_back(*parsed);
    if (comma == std::string_view::npos) return items;
    text.remove_prefix(comma + 1);
  }
}

}  // namespace

std::string quoted(std::string_view text) {
  constexpr size_t kMaxLength = 40;
  std::string result = "\"";
  result += text.substr(0, kMaxLength);
  result += text.size() > kMaxLength ? "…\"" : "\"";
  return result;
}

bool is_data(const Target& target) {
  const std::string& first = target.segments[0];
  return first == "v1" || first == "healthz" || first == "readyz" || first == "metrics";
}

std::optional<std::string_view> Target::parameter(std::string_view name) const {
  const auto found = std::ranges::find(query, name, [](const auto& item) { return item.first; });
  if (found == query.end()) return std::nullopt;
  return found->second;
}

std::string Target::path() const {
  std::string result;
  for (const std::string& segment : segments) result += '/' + segment;
  return result;
}

Result<Target> parse_target(std::string_view raw) {
  const auto no_empty_parameter = [] {
    return fail(Status::invalid_argument,
                "target: expected no \"?\" or \"&\" without a parameter behind it");
  };
  if (!std::ranges::all_of(raw, is_target_character)) {
    return fail(Status::invalid_argument,
                "target: contains a character that must be escaped with \"%\"");
  }
  bool is_absolute = false;
  for (const std::string_view scheme : {"http://", "https://"}) {
    if (!raw.starts_with(scheme)) continue;
    raw.remove_prefix(scheme.size());
    raw.remove_prefix(std::min(raw.find_first_of("/?"), raw.size()));
    is_absolute = true;
    break;
  }
  if (raw.starts_with('/')) {
    raw.remove_prefix(1);
  } else if (!is_absolute) {
    return fail(Status::invalid_argument, "target: expected a path that begins with \"/\"");
  }

  Target target;
  target.segments.reserve(8);  // as many as the URL of a chunk has
  const size_t mark = std::min(raw.find('?'), raw.size());
  std::string_view path = raw.substr(0, mark);
  std::string_view query = raw.substr(std::min(mark + 1, raw.size()));
  while (true) {
    const size_t slash = path.find('/');
    Result<std::string> segment =
        decode(path.substr(0, slash), EscapedSlash::refused, EscapedLetters::refused);
    if (!segment) return tl::unexpected(segment.error());
    if (*segment == "." || *segment == "..") {
      return fail(Status::invalid_argument,
                  "target: contains a \".\" or \"..\" segment: request the resolved path");
    }
    target.segments.push_back(std::move(*segment));
    if (slash == std::string_view::npos) break;
    path.remove_prefix(slash + 1);
  }

  // The page's program parses the page's query and reports errors. The server only reads the
  // volume's name, tokens and links from it.
  const bool is_for_page = !is_data(target);
  const auto letters = is_for_page ? EscapedLetters::allowed : EscapedLetters::refused;
  if (!is_for_page && mark + 1 == raw.size()) return no_empty_parameter();
  while (!query.empty()) {
    const size_t end = std::min(query.find('&'), query.size());
    const std::string_view item = query.substr(0, end);
    const bool is_last = end == query.size();
    query.remove_prefix(std::min(end + 1, query.size()));
    if (!is_for_page && (item.empty() || (query.empty() && !is_last))) return no_empty_parameter();
    if (item.empty()) continue;
    const size_t equals = std::min(item.find('='), item.size());
    Result<std::string> key = decode(item.substr(0, equals), EscapedSlash::allowed, letters);
    Result<std::string> value =
        decode(item.substr(std::min(equals + 1, item.size())), EscapedSlash::allowed, letters);
    if (is_for_page && (!key || !value)) continue;
    if (!key) return tl::unexpected(key.error());
    if (!value) return tl::unexpected(value.error());
    target.query.emplace_back(std::move(*key), std::move(*value));
  }
  return target;
}

std::optional<uint32_t> parse_index(std::string_view text, uint32_t max) {
  if (text.empty() || text.size() > 10 || (text[0] == '0' && text.size() > 1)) return std::nullopt;
  uint64_t value = 0;
  for (const char c : text) {
    if (c < '0' || c > '9') return std::nullopt;
    value = value * 10 + static_cast<uint64_t>(c - '0');
  }
  if (value > max) return std::nullopt;
  return static_cast<uint32_t>(value);
}

std::optional<Index3> parse_block(std::string_view text) {
  const size_t first = text.find('.');
  if (first == std::string_view::npos) return std::nullopt;
  const size_t second = text.find('.', first + 1);
  if (second == std::string_view::npos) return std::nullopt;
  const auto x = parse_index(text.substr(0, first), kMaxVoxelsPerAxis);
  const auto y = parse_index(text.substr(first + 1, second - first - 1), kMaxVoxelsPerAxis);
  const auto z = parse_index(text.substr(second + 1), kMaxVoxelsPerAxis);
  if (!x || !y || !z) return std::nullopt;
  return Index3{static_cast<int32_t>(*x), static_cast<int32_t>(*y), static_cast<int32_t>(*z)};
}

std::optional<double> parse_value(std::string_view text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  if (!std::isfinite(value)) return std::nullopt;
  return value;
}

std::optional<ValueRange> parse_value_range(std::string_view text) {
  const size_t dots = text.find("..");
  if (dots == std::string_view::npos) {
    const auto value = parse_value(text);
    if (!value) return std::nullopt;
    return ValueRange{*value, *value};
  }
  const auto low = parse_value(text.substr(0, dots));
  const auto high = parse_value(text.substr(dots + 2));
  if (!low || !high || !(*low <= *high)) return std::nullopt;
  return ValueRange{*low, *high};
}

std::optional<std::array<double, 6>> parse_box(std::string_view text) {
  std::array<double, 6> box;
  for (size_t i = 0; i < box.size(); ++i) {
    const size_t comma = text.find(',');
    if ((comma == std::string_view::npos) != (i + 1 == box.size())) return std::nullopt;
    const auto value = parse_value(text.substr(0, comma));
    if (!value) return std::nullopt;
    box[i] = *value;
    text.remove_prefix(std::min(comma + 1, text.size()));
  }
  return box;
}

Result<std::vector<Index3>> parse_blocks(std::string_view text) {
  return parse_list<Index3>(text, "blocks x.y.z", parse_block);
}

Result<std::vector<ChunkAddress>> parse_chunks(std::string_view text) {
  const auto parse = [](std::string_view item) -> std::optional<ChunkAddress> {
    const size_t first = item.find('/');
    if (first == std::string_view::npos) return std::nullopt;
    const size_t second = item.find('/', first + 1);
    if (second == std::string_view::npos) return std::nullopt;
    const auto level = parse_index(item.substr(0, first), 31);
    const auto block = parse_block(item.substr(first + 1, second - first - 1));
    const auto band = parse_index(item.substr(second + 1), 65535);
    if (!level || !block || !band) return std::nullopt;
    return ChunkAddress{BlockKey{*level, *block}, *band};
  };
  return parse_list<ChunkAddress>(text, "chunks level/x.y.z/band", parse);
}

}  // namespace isosplat::server
