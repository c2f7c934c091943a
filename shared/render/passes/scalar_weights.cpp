#include "shared/render/passes/scalar_weights.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace isosplat::render {

std::array<float, 3> scalar_weights(const RenderSettings& settings, const ValueMapping& mapping,
                                    double frame_unit, double isovalue, uint32_t level) {
  const double range = settings.colour_high - settings.colour_low;
  const double per_value = range != 0 ? 1 / range : 0;
  switch (settings.colour_by) {
    case ColourBy::isovalue:
      return {static_cast<float>((isovalue - settings.colour_low) * per_value), 0, 0};
    case ColourBy::gradient:
      return {static_cast<float>(-settings.colour_low * per_value),
              static_cast<float>(mapping.scale / frame_unit * per_value), 0};
    case ColourBy::level:
      return {static_cast<float>(level) / 7, 0, 0};
    case ColourBy::projection_error:
      return {0, 0, 2};
    case ColourBy::field:
      return {1, 0, 0};  // FIELD_NO_VALUES
    case ColourBy::isosurface:
    case ColourBy::depth:
      break;
  }
  return {0, 0, 0};
}

std::array<float, 3> field_weights(const RenderSettings& settings, const ValueMapping& field) {
  if (field_style(settings) == FieldStyle::categories) {
    const size_t count = std::min(settings.field_categories.size(), kMaxCategoryColours);
    return {static_cast<float>(field.scale),
            static_cast<float>(field.offset - settings.field_first_category),
            static_cast<float>(count)};
  }
  const auto [low, high] = field_range(settings);
  if (settings.field_scale == FieldScale::logarithmic) {
    // The logarithm of the ratio to the low limit.
    const double octaves = std::log2(high / low);
    return {static_cast<float>(field.scale / low), static_cast<float>(field.offset / low),
            static_cast<float>(octaves != 0 ? 1 / octaves : 1e30)};
  }
  const double range = high - low, per_value = range != 0 ? 1 / range : 0;
  return {static_cast<float>(field.scale * per_value),
          static_cast<float>((field.offset - low) * per_value), 0};
}

float least_missing(const ValueMapping& field) {
  return field.has_missing ? float(kMissingVoxel) : std::numeric_limits<float>::max();
}

}  // namespace isosplat::render
