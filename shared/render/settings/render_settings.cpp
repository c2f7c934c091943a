#include "shared/render/settings/render_settings.h"

#include <algorithm>
#include <cmath>

namespace isosplat::render {

FieldRange field_range(const RenderSettings& settings) {
  FieldRange range{settings.colour_low, settings.colour_high};
  if (settings.field_scale == FieldScale::symmetric) {
    const double most = std::max(std::abs(range.low), std::abs(range.high));
    return {-most, most};
  }
  if (settings.field_scale == FieldScale::logarithmic) {
    if (!(range.high > 0)) range.high = 1;
    if (!(range.low > 0)) range.low = range.high / 1000;
  }
  return range;
}

FieldStyle field_style(const RenderSettings& settings) {
  if (settings.colour_by != ColourBy::field) return FieldStyle::none;
  if (!settings.field_categories.empty()) return FieldStyle::categories;
  const bool has_lines = std::isfinite(settings.field_lines) && settings.field_lines > 0;
  return has_lines ? FieldStyle::lines : FieldStyle::values;
}

}  // namespace isosplat::render
