#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace isosplat::import {

/// Removes the next line from `text` and returns it without "\n" or "\r\n". Nothing if there is no
/// line end.
std::optional<std::string_view> pop_line(std::string_view& text);

/// The text without white space at both ends.
std::string_view trimmed(std::string_view text);

std::string lower_case(std::string_view text);

/// The text with "?" for every byte that is not printable ASCII, for messages and notes.
std::string printable(std::string_view text);

/// The words of a line, separated by white space.
std::vector<std::string_view> words(std::string_view line);

/// Parses all of `text` as a whole number. Nothing if it is not one or does not fit.
std::optional<int64_t> whole_number(std::string_view text);

/// Parses all of `text` as a number: "1.5", "-2e3", "+4", "nan". Nothing if it is not one.
std::optional<double> number_in(std::string_view text);

/// Parses numbers separated by white space. Nothing if any word is not a number.
std::optional<std::vector<double>> numbers_in(std::string_view line);

/// Parses whole numbers separated by white space. Nothing if any word is not one.
std::optional<std::vector<int64_t>> whole_numbers(std::string_view line);

}  // namespace isosplat::import
