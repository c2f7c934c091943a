#include "native/cli/numbers.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>
#include <limits>

namespace isosplat::cli {
namespace {

template <class T>
std::optional<T> parse(std::string_view text) {
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
  T number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return number;
}

/// Splits a text at its first (count − 1) characters that are in `separators`. No value if there
/// are fewer.
template <size_t count>
std::optional<std::array<std::string_view, count>> split(std::string_view text,
                                                         std::string_view separators) {
  std::array<std::string_view, count> parts;
  for (size_t i = 0; i + 1 < count; ++i) {
    const size_t end = text.find_first_of(separators);
    if (end == text.npos) return std::nullopt;
    parts[i] = text.substr(0, end);
    text.remove_prefix(end + 1);
  }
  parts.back() = text;
  return parts;
}

constexpr std::string_view kSeparators = "xX,:";

std::string found(const std::string& text) {
  return text.empty() ? "nothing" : "'" + text + "'";
}

CLI::Validator number_check(double min, double max, const std::string& expected) {
  return CLI::Validator(
      [=](std::string& text) -> std::string {
        const auto number = parse_number(text);
        if (number && *number >= min && *number <= max) return {};
        return fmt::format("expected {}, found {}", expected, found(text));
      },
      "");
}

}  // namespace

std::optional<double> parse_number(std::string_view text) {
  const auto number = parse<double>(text);
  return number && std::isfinite(*number) ? number : std::nullopt;
}

std::optional<int64_t> parse_whole_number(std::string_view text) {
  return parse<int64_t>(text);
}

std::optional<uint64_t> parse_bytes(std::string_view text) {
  const size_t end = std::min(text.find_first_not_of("0123456789."), text.size());
  const auto number = parse_number(text.substr(0, end));
  if (!number) return std::nullopt;
  std::string unit(text.substr(end));
  for (char& c : unit) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  double factor = 1;
  if (unit == "K" || unit == "KB" || unit == "KIB") {
    factor = 1024;
  } else if (unit == "M" || unit == "MB" || unit == "MIB") {
    factor = 1024.0 * 1024;
  } else if (unit == "G" || unit == "GB" || unit == "GIB") {
    factor = 1024.0 * 1024 * 1024;
  } else if (unit == "T" || unit == "TB" || unit == "TIB") {
    factor = 1024.0 * 1024 * 1024 * 1024;
  } else if (!unit.empty() && unit != "B") {
    return std::nullopt;
  }
  const double bytes = *number * factor;
  if (bytes > 9e18) return std::nullopt;
  return static_cast<uint64_t>(bytes);
}

std::optional<Vec3d> parse_triple(std::string_view text) {
  const auto parts = split<3>(text, kSeparators);
  if (!parts) return std::nullopt;
  const auto x = parse_number((*parts)[0]), y = parse_number((*parts)[1]),
             z = parse_number((*parts)[2]);
  if (!x || !y || !z) return std::nullopt;
  return Vec3d{*x, *y, *z};
}

std::optional<Vec3<int64_t>> parse_whole_triple(std::string_view text) {
  const auto parts = split<3>(text, kSeparators);
  if (!parts) return std::nullopt;
  const auto x = parse_whole_number((*parts)[0]), y = parse_whole_number((*parts)[1]),
             z = parse_whole_number((*parts)[2]);
  if (!x || !y || !z) return std::nullopt;
  return Vec3<int64_t>{*x, *y, *z};
}

std::optional<PixelSize> parse_pixel_size(std::string_view text) {
  if (const auto both = parse_whole_number(text)) return PixelSize{*both, *both};
  const auto parts = split<2>(text, "xX");
  if (!parts) return std::nullopt;
  const auto width = parse_whole_number((*parts)[0]), height = parse_whole_number((*parts)[1]);
  if (!width || !height) return std::nullopt;
  return PixelSize{*width, *height};
}

CLI::Validator is_number() {
  constexpr double kMax = std::numeric_limits<double>::max();
  return number_check(-kMax, kMax, "a number such as 60.5");
}

CLI::Validator is_number(double min, double max) {
  return number_check(min, max, fmt::format("a number from {} to {}", min, max));
}

CLI::Validator is_above_zero() {
  return number_check(std::numeric_limits<double>::min(), std::numeric_limits<double>::max(),
                      "a number above 0");
}

CLI::Validator is_whole_number(int64_t min, int64_t max) {
  return CLI::Validator(
      [=](std::string& text) -> std::string {
        const auto number = parse_whole_number(text);
        if (number && *number >= min && *number <= max) return {};
        return max == std::numeric_limits<int64_t>::max()
                   ? fmt::format("expected a whole number of at least {}, found {}", min,
                                 found(text))
                   : fmt::format("expected a whole number from {} to {}, found {}", min, max,
                                 found(text));
      },
      "");
}

}  // namespace isosplat::cli
