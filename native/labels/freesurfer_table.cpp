#include "native/labels/table_text.h"

namespace isosplat {

Result<LabelTable> parse_freesurfer_table(std::string_view text) {
  LabelTable table;
  for (const TableLine& line : table_lines(text)) {
    const auto words = table_words(line.text);
    // The transparency is not used: it is 0 in all known tables.
    const bool has_words = words.size() == 5 || words.size() == 6;
    const auto value = has_words ? table_integer(words[0]) : std::nullopt;
    LabelEntry entry;
    if (has_words) entry.colour = table_colour(words[2], words[3], words[4], 255);
    if (!value || !entry.colour) return table_fault(line, "value, name, r, g, b and transparency");
    entry.name = label_name(words[1]);
    if (auto added = add_entry(table, *value, std::move(entry)); !added) {
      return tl::unexpected(added.error());
    }
  }
  return table;
}

}  // namespace isosplat
