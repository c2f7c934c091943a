#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "shared/core/base/vec3.h"

// Parses the numbers of the command line. A number is decimal and finite, and the whole text must
// belong to it: "nan", "inf", hexadecimal digits, blanks and trailing characters are rejected. The
// parsers return no value for a text that they reject.
namespace isosplat::cli {

/// "60.5", "-300", "1e3".
std::optional<double> parse_number(std::string_view text);

/// "64", "-3". Numbers outside of 64 bits are rejected.
std::optional<int64_t> parse_whole_number(std::string_view text);

/// "512M", "1.5G", "1000000": bytes, with binary units.
std::optional<uint64_t> parse_bytes(std::string_view text);

/// Three numbers separated by "x", "," or ":".
std::optional<Vec3d> parse_triple(std::string_view text);

/// Three whole numbers, such as 256x256x128.
std::optional<Vec3<int64_t>> parse_whole_triple(std::string_view text);

/// "1024x768"; a single number is both width and height.
struct PixelSize {
  int64_t width = 0, height = 0;
};
std::optional<PixelSize> parse_pixel_size(std::string_view text);

/// Validators for options with numbers (CLI::Option::check); in a list, each item is checked. They
/// reject the texts that parse_number or parse_whole_number rejects, and numbers outside of [min,
/// max]. The message names the expected and the found value.
CLI::Validator is_number();
CLI::Validator is_number(double min, double max);
CLI::Validator is_above_zero();
CLI::Validator is_whole_number(int64_t min, int64_t max);

}  // namespace isosplat::cli
