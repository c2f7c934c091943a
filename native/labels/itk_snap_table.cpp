#include "native/labels/table_text.h"

namespace isosplat {

Result<LabelTable> parse_itk_snap_table(std::string_view text) {
  constexpr std::string_view kForm = "value, r, g, b, a, two flags, and a name in quotes";
  LabelTable table;
  for (const TableLine& line : table_lines(text)) {
    const size_t quote = line.text.find('"');
    const auto words = table_words(line.text.substr(0, quote));
    if (quote == std::string_view::npos || words.size() != 7) return table_fault(line, kForm);
    const auto value = table_integer(words[0]);
    const auto alpha = table_number(words[4]);
    LabelEntry entry;
    entry.colour = table_colour(words[1], words[2], words[3], 255);
    if (!value || !entry.colour || !alpha || *alpha < 0 || *alpha > 1) {
      return table_fault(line, kForm);
    }
    entry.opacity = static_cast<float>(*alpha);
    entry.visible = words[6] != "0";  // of the mesh, which is the surface
    const std::string_view name = line.text.substr(quote + 1);
    entry.name = label_name(name.substr(0, name.rfind('"')));
    if (auto added = add_entry(table, *value, std::move(entry)); !added) {
      return tl::unexpected(added.error());
    }
  }
  return table;
}

}  // namespace isosplat
