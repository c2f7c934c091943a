#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "native/labels/label_table.h"

// Functions for the parsers of tables.
namespace isosplat {

/// A name for people: control characters become blanks, and what exceeds kMaxLabelName is cut
/// between two characters.
std::string label_name(std::string_view text);

/// A finite number that is the whole text.
std::optional<double> table_number(std::string_view text);

/// An integer up to ±2^53 that is the whole text.
std::optional<int64_t> table_integer(std::string_view text);

/// The colour of three components from 0 to `most`. Nothing if one is not in this range.
std::optional<std::array<float, 3>> table_colour(std::string_view r, std::string_view g,
                                                 std::string_view b, double most);

/// A line of a text, without blanks at its ends.
struct TableLine {
  size_t number;  ///< from 1
  std::string_view text;
};

/// The lines that are neither empty nor comments (#).
std::vector<TableLine> table_lines(std::string_view text);

/// The words of a line, separated by blanks.
std::vector<std::string_view> table_words(std::string_view line);

/// The error of a line. `expected`: what was expected there.
tl::unexpected<Error> table_fault(const TableLine& line, std::string_view expected);

/// Adds an entry. Errors: malformed_volume if there are more than kMaxTableEntries.
Result<void> add_entry(LabelTable& table, int64_t value, LabelEntry entry);

}  // namespace isosplat
