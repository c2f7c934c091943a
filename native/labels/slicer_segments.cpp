#include <map>

#include "native/labels/table_text.h"

namespace isosplat {

LabelTable parse_slicer_segments(std::string_view header, int64_t layer) {
  constexpr std::string_view kSegment = "Segment", kAssigns = ":=";
  struct Segment {
    std::optional<int64_t> value, layer;
    LabelEntry entry;
  };
  std::map<int64_t, Segment> segments;
  while (!header.empty()) {
    const size_t end = std::min(header.find('\n'), header.size());
    std::string_view line = header.substr(0, end);
    if (line.ends_with('\r')) line.remove_suffix(1);
    if (line.empty()) break;  // the voxels follow
    header.remove_prefix(std::min(end + 1, header.size()));
    const size_t field = line.find('_'), text = line.find(kAssigns);
    if (!line.starts_with(kSegment) || field == std::string_view::npos ||
        text == std::string_view::npos || field > text) {
      continue;
    }
    const auto number = table_integer(line.substr(kSegment.size(), field - kSegment.size()));
    if (!number || (segments.size() >= kMaxTableEntries && !segments.contains(*number))) continue;
    const std::string_view key = line.substr(field + 1, text - field - 1);
    const std::string_view value = line.substr(text + kAssigns.size());
    Segment& segment = segments[*number];
    if (key == "Name") segment.entry.name = label_name(value);
    if (key == "LabelValue") segment.value = table_integer(value);
    if (key == "Layer") segment.layer = table_integer(value);
    if (key == "Color") {
      const auto words = table_words(value);
      if (words.size() == 3) segment.entry.colour = table_colour(words[0], words[1], words[2], 1);
    }
  }
  LabelTable table;
  for (auto& [number, segment] : segments) {
    // Before version 4.11 of Slicer, each segment was a separate layer, with the value 1.
    const bool is_old = !segment.value && !segment.layer;
    const int64_t value = segment.value.value_or(1),
                  of = segment.layer.value_or(is_old ? number : 0);
    if (of == layer) table[value] = std::move(segment.entry);
  }
  return table;
}

}  // namespace isosplat
