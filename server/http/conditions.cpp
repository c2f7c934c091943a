#include "server/http/conditions.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <boost/beast/core/string.hpp>
#include <boost/beast/http/rfc7230.hpp>
#include <limits>
#include <optional>

#define XXH_INLINE_ALL
#include <xxhash.h>

namespace isosplat::server {
namespace {

namespace beast = boost::beast;

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
  return text;
}

/// A number of digits only. Numbers above 64 bits become the largest one.
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
  return fmt::format("\"{:016x}{:016x}\"", hash.high64, hash.low64);
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

ParsedRange parse_range(std::string_view field, uint64_t size) {
  constexpr ParsedRange kWhole{};
  constexpr ParsedRange kUnsatisfiable{RangeKind::unsatisfiable, {}};
  field = trimmed(field);
  const size_t equals = field.find('=');
  if (equals == std::string_view::npos) return kWhole;
  if (!beast::iequals(trimmed(field.substr(0, equals)), "bytes")) return kWhole;
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

ParsedRange requested_range(const Request& request, std::string_view etag, uint64_t size) {
  const bool applies = request.method == Method::get && !request.range.empty() &&
                       (request.if_range.empty() || request.if_range == etag);
  return applies ? parse_range(request.range, size) : ParsedRange{};
}

Response begin_response(const Request& request, const std::string& etag, CachePolicy policy,
                        bool is_private) {
  if (!request.if_match.empty() && !names_etag(request.if_match, etag, /*weak=*/false)) {
    return error_response(412, "precondition_failed",
                          "If-Match: the content has another ETag: request it without If-Match");
  }
  Response response;
  response.headers.reserve(384);  // enough for most responses
  response.set("ETag", etag);
  response.set("Cache-Control", policy == CachePolicy::immutable
                                    ? (is_private ? "private, max-age=31536000, immutable"
                                                  : "public, max-age=31536000, immutable")
                                    : (is_private ? "private, no-cache" : "no-cache"));
  if (!request.if_none_match.empty() && names_etag(request.if_none_match, etag, /*weak=*/true)) {
    response.status = 304;
  }
  return response;
}

bool is_complete(const Response& response) {
  return response.status != 200;
}

bool accepts_encoding(std::string_view field, Encoding encoding) {
  const std::string_view name = encoding == Encoding::brotli ? "br" : "gzip";
  bool wildcard_admits = false;
  for (const auto& [coding, parameters] : beast::http::ext_list(field)) {
    // q=0, q=0.0 and q=0.000 exclude. All other weights admit: the server sends the smallest
    // variant.
    const auto is_zero = [](const auto& parameter) {
      return beast::iequals(parameter.first, "q") &&
             parameter.second.find_first_not_of("0.") == parameter.second.npos;
    };
    const bool excluded = std::any_of(parameters.begin(), parameters.end(), is_zero);
    if (beast::iequals(coding, name) ||
        (encoding == Encoding::gzip && beast::iequals(coding, "x-gzip"))) {
      return !excluded;
    }
    if (coding == "*") wildcard_admits = !excluded;
  }
  return wildcard_admits;
}

}  // namespace isosplat::server
