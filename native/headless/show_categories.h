#pragma once

#include <span>
#include <vector>

#include "shared/core/categories/categories.h"
#include "shared/render/settings/render_settings.h"

namespace isosplat {

/// Adds categories to those of other stores. Those that have the values of others are left out, as
/// are those beyond kMaxCategorySpan.
void add_categories(std::span<const Category> more, std::vector<Category>& to);

/// Sets the colours of the categories of a field; none: its values are no labels.
void show_categories(std::span<const Category> categories, render::RenderSettings& settings);

}  // namespace isosplat
