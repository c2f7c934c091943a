#include <algorithm>
#include <cctype>

#include "native/labels/table_text.h"

namespace isosplat {
namespace {

/// The fields of a line. Nothing if a quoted field does not end.
std::optional<std::vector<std::string>> fields_of(std::string_view line) {
  std::vector<std::string> fields(1);
  bool is_quoted = false;
  for (size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (c == '"') {
      if (is_quoted && i + 1 < line.size() && line[i + 1] == '"') {
        fields.back() += line[++i];
      } else {
        is_quoted = !is_quoted;
      }
    } else if (c == ',' && !is_quoted) {
      fields.emplace_back();
    } else {
      fields.back() += c;
    }
  }
  if (is_quoted) return std::nullopt;
  return fields;
}

std::string lower(std::string text) {
  text = label_name(text);
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

}  // namespace

Result<LabelTable> parse_csv_table(std::string_view text) {
  constexpr size_t kNone = static_cast<size_t>(-1);
  const std::vector<TableLine> lines = table_lines(text);
  LabelTable table;
  if (lines.empty()) return table;
  const auto names = fields_of(lines.front().text);
  const auto column = [&](std::initializer_list<std::string_view> of) {
    for (size_t i = 0; names && i < names->size(); ++i) {
      if (std::find(of.begin(), of.end(), lower((*names)[i])) != of.end()) return i;
    }
    return kNone;
  };
  const size_t value_at = column({"value", "label", "id", "index"});
  const size_t name_at = column({"name"});
  const std::array<size_t, 4> at{column({"r", "red"}), column({"g", "green"}),
                                 column({"b", "blue"}), column({"a", "alpha"})};
  if (value_at == kNone) {
    return table_fault(lines.front(), "the names of columns: value, and any of name, r, g, b, a");
  }
  for (size_t i = 1; i < lines.size(); ++i) {
    const auto fields = fields_of(lines[i].text);
    if (!fields) return table_fault(lines[i], "a closing quote");
    const auto field = [&](size_t index) {
      return index < fields->size() ? std::string_view((*fields)[index]) : std::string_view();
    };
    const auto value = table_integer(field(value_at));
    if (!value) return table_fault(lines[i], "an integer as value");
    LabelEntry entry;
    entry.name = label_name(field(name_at));
    const bool has_colour = std::any_of(at.begin(), at.begin() + 3, [&](size_t index) {
      return !label_name(field(index)).empty();
    });
    if (has_colour) {
      entry.colour = table_colour(field(at[0]), field(at[1]), field(at[2]), 255);
      if (!entry.colour) return table_fault(lines[i], "r, g and b from 0 to 255");
    }
    if (!label_name(field(at[3])).empty()) {
      const auto alpha = table_number(field(at[3]));
      if (!alpha || *alpha < 0 || *alpha > 255) return table_fault(lines[i], "a from 0 to 255");
      entry.opacity = static_cast<float>(*alpha / 255);
    }
    if (auto added = add_entry(table, *value, std::move(entry)); !added) {
      return tl::unexpected(added.error());
    }
  }
  return table;
}

}  // namespace isosplat
