#include "server/conditions.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <limits>
#include <optional>

#define XXH_INLINE_ALL
#include <xxhash.h>

namespace isosplat {
namespace {

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
  return text;
}

bool equal_ignoring_case(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  for (size_t i = 0; i < a.size(); ++i) {
    const auto lower = [](char c) {
      return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    };
    if (lower(a[i]) != lower(b[i])) return false;
  }
  return true;
}

/// Digits only; more than 64 bits hold counts as the largest.
std::optional<uint64_t> parse_position(std::string_view text) {
  if (text.empty()) return std::nullopt;
  constexpr uint64_t kMax = std::numeric_limits<uint64_t>::max();
  uint64_t value = 0;
  for (const char c : text) {
    if (c < '0' || c > '9') return std::nullopt;
    const auto digit = static_cast<uint64_t>(c - '0');
    value = value > (kMax - digit) / 10 ? kMax : value * 10 + digit;
  }
  return value;
}

}  // namespace

std::string etag_for(std::string_view bytes) {
  const XXH128_hash_t hash = XXH3_128bits(bytes.data(), bytes.size());
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), "\"%016llx%016llx\"",
                static_cast<unsigned long long>(hash.high64),
                static_cast<unsigned long long>(hash.low64));
  return text.data();
}

bool names_etag(std::string_view field, std::string_view etag, bool weak) {
  field = trimmed(field);
  if (field == "*") return true;
  while (!field.empty()) {
    bool is_weak = false;
    if (field.starts_with("W/")) {
      is_weak = true;
      field.remove_prefix(2);
    }
    if (!field.starts_with('"')) return false;
    const size_t end = field.find('"', 1);
    if (end == std::string_view::npos) return false;
    if ((weak || !is_weak) && field.substr(0, end + 1) == etag) return true;
    field = trimmed(field.substr(end + 1));
    if (!field.empty() && field.front() != ',') return false;
    while (!field.empty() && field.front() == ',') field = trimmed(field.substr(1));
  }
  return false;
}

RangeAnswer parse_range(std::string_view field, uint64_t size) {
  constexpr RangeAnswer kWhole{};
  constexpr RangeAnswer kUnsatisfiable{RangeKind::unsatisfiable, {}};
  field = trimmed(field);
  const size_t equals = field.find('=');
  if (equals == std::string_view::npos) return kWhole;
  if (!equal_ignoring_case(trimmed(field.substr(0, equals)), "bytes")) return kWhole;
  const std::string_view spec = trimmed(field.substr(equals + 1));
  const size_t dash = spec.find('-');
  if (dash == std::string_view::npos || spec.find(',') != std::string_view::npos) return kWhole;

  if (dash == 0) {
    const auto length = parse_position(spec.substr(1));
    if (!length) return kWhole;
    if (*length == 0 || size == 0) return kUnsatisfiable;
    return {RangeKind::part, {size - std::min(*length, size), size - 1}};
  }
  const auto first = parse_position(spec.substr(0, dash));
  if (!first) return kWhole;
  uint64_t last = std::numeric_limits<uint64_t>::max();
  if (dash + 1 < spec.size()) {
    const auto parsed = parse_position(spec.substr(dash + 1));
    if (!parsed || *parsed < *first) return kWhole;
    last = *parsed;
  }
  if (*first >= size) return kUnsatisfiable;
  return {RangeKind::part, {*first, std::min(last, size - 1)}};
}

bool accepts_encoding(std::string_view field, Encoding encoding) {
  const std::string_view name = encoding == Encoding::brotli ? "br" : "gzip";
  bool by_star = false;
  while (!field.empty()) {
    const size_t comma = std::min(field.find(','), field.size());
    const std::string_view item = field.substr(0, comma);
    field.remove_prefix(std::min(comma + 1, field.size()));
    const size_t semicolon = std::min(item.find(';'), item.size());
    const std::string_view coding = trimmed(item.substr(0, semicolon));
    const std::string_view parameter = trimmed(item.substr(semicolon));
    // q=0, q=0.0, q=0.000 exclude; any other weight admits: the server prefers the smallest.
    const size_t q = parameter.find('=');
    const bool excluded =
        q != std::string_view::npos && trimmed(parameter.substr(q + 1)).starts_with('0') &&
        parameter.substr(q + 1).find_first_of("123456789") == std::string_view::npos;
    if (equal_ignoring_case(coding, name) ||
        (encoding == Encoding::gzip && equal_ignoring_case(coding, "x-gzip"))) {
      return !excluded;
    }
    if (coding == "*") by_star = !excluded;
  }
  return by_star;
}

}  // namespace isosplat
