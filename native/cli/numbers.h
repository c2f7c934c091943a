#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "shared/base/vec3.h"

// The one parser of numbers on the command line. Numbers are decimal and finite, and make up all of
// the text: no "nan", "inf", hexadecimal digits, blanks, or anything behind them.
namespace isosplat::cli {

/// "60.5", "-300", "1e3". Nothing for anything else.
std::optional<double> parse_number(std::string_view text);

/// "64", "-3". Nothing for anything else, and where it does not fit.
std::optional<int64_t> parse_whole_number(std::string_view text);

/// "512M", "1.5G", "1000000": bytes, with binary units. Nothing for anything else.
std::optional<uint64_t> parse_bytes(std::string_view text);

/// Three numbers separated by "x", "," or ":". Nothing for anything else.
std::optional<Vec3d> parse_triple(std::string_view text);

/// Three whole numbers, as 256x256x128. Nothing for anything else.
std::optional<Vec3<int64_t>> parse_whole_triple(std::string_view text);

/// "1024x768"; one number stands for both. Nothing for anything else.
struct PixelSize {
  int64_t width = 0, height = 0;
};
std::optional<PixelSize> parse_pixel_size(std::string_view text);

/// Checks for options with numbers (CLI::Option::check), also for each item of a list. They refuse
/// what parse_number refuses, and what is out of bounds, with what was expected and found.
CLI::Validator is_number();
CLI::Validator is_number(double least, double most);
CLI::Validator is_above_zero();
CLI::Validator is_whole_number(int64_t least, int64_t most);

}  // namespace isosplat::cli
