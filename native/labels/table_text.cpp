#include "native/labels/table_text.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>

namespace isosplat {
namespace {

constexpr std::string_view kBlanks = " \t\r";

std::string_view trimmed(std::string_view text) {
  const size_t begin = text.find_first_not_of(kBlanks);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kBlanks) - begin + 1);
}

}  // namespace

std::string label_name(std::string_view text) {
  std::string name(trimmed(text));
  for (char& c : name) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = ' ';
  }
  if (name.size() > kMaxLabelName) {
    size_t end = kMaxLabelName;
    // Bytes 10xxxxxx continue a character.
    while (end > 0 && (static_cast<unsigned char>(name[end]) & 0xC0) == 0x80) --end;
    name.resize(end);
  }
  return name;
}

std::optional<double> table_number(std::string_view text) {
  text = trimmed(text);
  if (text.empty() || text.size() > 64) return std::nullopt;
  const std::string copy(text);
  char* end = nullptr;
  const double value = std::strtod(copy.c_str(), &end);
  if (end != copy.c_str() + copy.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::optional<int64_t> table_integer(std::string_view text) {
  const auto value = table_number(text);
  if (!value || std::abs(*value) > 9007199254740992.0 || *value != std::floor(*value)) {
    return std::nullopt;
  }
  return static_cast<int64_t>(*value);
}

std::optional<std::array<float, 3>> table_colour(std::string_view r, std::string_view g,
                                                 std::string_view b, double most) {
  std::array<float, 3> colour{};
  size_t i = 0;
  for (const std::string_view text : {r, g, b}) {
    const auto component = table_number(text);
    if (!component || *component < 0 || *component > most) return std::nullopt;
    colour[i++] = static_cast<float>(*component / most);
  }
  return colour;
}

std::vector<TableLine> table_lines(std::string_view text) {
  std::vector<TableLine> lines;
  for (size_t number = 1; !text.empty(); ++number) {
    const size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = trimmed(text.substr(0, end));
    if (!line.empty() && line[0] != '#') lines.push_back({number, line});
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return lines;
}

std::vector<std::string_view> table_words(std::string_view line) {
  std::vector<std::string_view> words;
  for (line = trimmed(line); !line.empty(); line = trimmed(line)) {
    const size_t end = std::min(line.find_first_of(kBlanks), line.size());
    words.push_back(line.substr(0, end));
    line.remove_prefix(end);
  }
  return words;
}

tl::unexpected<Error> table_fault(const TableLine& line, std::string_view expected) {
  constexpr size_t kMost = 60;
  return fail(Status::malformed_volume,
              fmt::format("line {}: expected {}, found '{}'", line.number, expected,
                          label_name(line.text.substr(0, kMost))));
}

Result<void> add_entry(LabelTable& table, int64_t value, LabelEntry entry) {
  if (table.size() >= kMaxTableEntries && !table.contains(value)) {
    return fail(Status::malformed_volume,
                fmt::format("expected at most {} labels in a table, found more", kMaxTableEntries));
  }
  table[value] = std::move(entry);
  return {};
}

}  // namespace isosplat
