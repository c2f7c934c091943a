#include <algorithm>

#include "native/labels/table_text.h"
#include "shared/import/text/xml_scanner.h"

namespace isosplat {

LabelTable parse_workbench_table(std::string_view xml) {
  LabelTable table;
  const size_t begin = xml.rfind("<LabelTable");
  if (begin == std::string_view::npos) return table;
  import::XmlScanner scanner(xml.substr(begin));
  while (const auto tag = scanner.next()) {
    if (tag->name == "LabelTable" && tag->ends) break;
    if (tag->name != "Label" || !tag->begins) continue;
    const auto value = table_integer(tag->attribute("Key").value_or(""));
    if (!value || table.size() >= kMaxTableEntries) continue;
    LabelEntry entry;
    entry.name = tag->ends ? "" : label_name(scanner.content());
    entry.colour =
        table_colour(tag->attribute("Red").value_or(""), tag->attribute("Green").value_or(""),
                     tag->attribute("Blue").value_or(""), 1);
    if (const auto alpha = table_number(tag->attribute("Alpha").value_or(""))) {
      entry.opacity = static_cast<float>(std::clamp(*alpha, 0.0, 1.0));
    }
    table[*value] = std::move(entry);
  }
  return table;
}

}  // namespace isosplat
