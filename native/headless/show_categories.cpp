#include "native/headless/show_categories.h"

#include <algorithm>

namespace isosplat {

void add_categories(std::span<const Category> more, std::vector<Category>& to) {
  for (const Category& category : more) {
    const auto at = std::ranges::lower_bound(to, category.value, {}, &Category::value);
    if (at != to.end() && at->value == category.value) continue;
    if (!to.empty() && (category.value - to.front().value > kMaxCategorySpan ||
                        to.back().value - category.value > kMaxCategorySpan)) {
      continue;
    }
    to.insert(at, category);
  }
}

void show_categories(std::span<const Category> categories, render::RenderSettings& settings) {
  settings.field_categories.clear();
  if (categories.empty()) return;
  const int64_t first = categories.front().value;
  settings.field_first_category = static_cast<double>(first);
  settings.field_categories.resize(static_cast<size_t>(categories.back().value - first + 1));
  for (const Category& category : categories) {
    settings.field_categories[static_cast<size_t>(category.value - first)] = category.colour;
  }
}

}  // namespace isosplat
