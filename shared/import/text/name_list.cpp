#include "shared/import/text/name_list.h"

#include <fmt/format.h>

#include <algorithm>

namespace isosplat::import {

std::string name_list(const std::vector<std::string>& names, size_t most) {
  std::string text;
  for (size_t i = 0; i < std::min(names.size(), most); ++i) {
    if (i > 0) text += ", ";
    text += names[i];
  }
  if (names.size() > most) text += fmt::format(" and {} more", names.size() - most);
  return text;
}

}  // namespace isosplat::import
