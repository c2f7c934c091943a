#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "shared/base/status.h"

namespace isosplat {

/// The first bytes of a file, up to `limit`: where formats with text headers are looked into.
/// Errors: io_error.
Result<std::string> read_beginning(const std::filesystem::path& path, size_t limit = 64 * 1024);

/// Takes the next line off `text`, without its "\n" or "\r\n". Nothing where no line end follows.
std::optional<std::string_view> take_line(std::string_view& text);

/// Without white space at both ends.
std::string_view trimmed(std::string_view text);

std::string lower_case(std::string_view text);

/// The words of a line, separated by white space.
std::vector<std::string_view> words(std::string_view line);

/// A whole number that makes up all of `text`. Nothing otherwise, or where it does not fit.
std::optional<int64_t> whole_number(std::string_view text);

/// A number that makes up all of `text`: "1.5", "-2e3", "+4", "nan". Nothing otherwise.
std::optional<double> number_in(std::string_view text);

/// Numbers, separated by white space. Nothing where anything else is among them.
std::optional<std::vector<double>> numbers_in(std::string_view line);

/// Whole numbers, separated by white space. Nothing where anything else is among them.
std::optional<std::vector<int64_t>> whole_numbers(std::string_view line);

}  // namespace isosplat
