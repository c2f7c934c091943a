#include "native/labels/label_table.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <string_view>

namespace isosplat {

bool is_zero_a_label(const LabelTable& table) {
  const auto found = table.find(0);
  if (found == table.end() || found->second.opacity == 0) return false;
  std::string name = found->second.name;
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  constexpr std::array<std::string_view, 7> kBackgrounds{
      "", "background", "clear label", "none", "null", "unknown", "???"};
  return std::find(kBackgrounds.begin(), kBackgrounds.end(), name) == kBackgrounds.end();
}

}  // namespace isosplat
