#include "shared/render/passes/line_weights.h"

#include <algorithm>
#include <cmath>

#include "shared/render/settings/colour_maps.h"
#include "shared/render/settings/light.h"

namespace isosplat::render {

namespace {

/// The part of a colour map, from 0 to 1, on which lines are dark: black contrasts with its colours
/// at least as much as white. It is one interval in each map
/// (tests/native/render_lines_gpu_test.cpp).
std::array<float, 2> dark_lines(int map) {
  constexpr float kMiddle = 0.1791f;  // luminance: (1 + 0.05) / (Y + 0.05) = (Y + 0.05) / 0.05
  std::array<float, 2> ends{2, -1};
  float before = 0;
  for (int i = 0; i < 256; ++i) {
    const auto* rgb = kColourMapTable[map][i];
    const Vec3f linear =
        to_linear(Vec3f{float(rgb[0]), float(rgb[1]), float(rgb[2])} * (1 / 255.f));
    const float luminance = 0.2126f * linear.x + 0.7152f * linear.y + 0.0722f * linear.z;
    // Between two colours, the texture interpolates linear ones.
    const float crossing = i > 0 ? (kMiddle - before) / (luminance - before) - 1 : 0;
    if (luminance >= kMiddle) {
      if (ends[0] > 1) ends[0] = (static_cast<float>(i) + (before < kMiddle ? crossing : 0)) / 255;
      ends[1] = i < 255 ? static_cast<float>(i) / 255 : 2;  // 1, with rounding
    } else if (before >= kMiddle) {
      ends[1] = (static_cast<float>(i) + crossing) / 255;
    }
    before = luminance;
  }
  return ends;
}

/// Of each map.
std::array<float, 2> known_dark_lines(ColourMap map) {
  static const auto all = [] {
    std::array<std::array<float, 2>, kColourMaps> parts;
    for (int i = 0; i < kColourMaps; ++i) parts[size_t(i)] = dark_lines(i);
    return parts;
  }();
  return all[static_cast<size_t>(std::clamp(static_cast<int>(map), 0, kColourMaps - 1))];
}

}  // namespace

LineWeights line_weights(const RenderSettings& settings, const ValueMapping& field) {
  constexpr double kMostPerValue = 16, kLeastPerValue = 1e-15, kMostPerDecade = 10000;
  const auto [low, high] = field_range(settings);
  const auto [dark_from, dark_to] = known_dark_lines(settings.colour_map);
  const float steps = settings.field_steps >= 2 ? static_cast<float>(settings.field_steps) : 0;
  const LineWeights none{{0, 0.5f, 0, steps}, {0, dark_from, dark_to}};
  if (field_style(settings) != FieldStyle::lines) return none;
  const double interval = settings.field_lines;
  // The numbers of lines are relative to the one that is nearest to the low end: floats around 0
  // are exact, while 1 − 1e-9 would be a line.
  if (settings.field_scale == FieldScale::logarithmic) {
    if (interval * kMostPerDecade < 1 || interval * kLeastPerValue > 1) return none;
    const double decades = std::log10(high / low), first = std::log10(low) / interval;
    return {{0, static_cast<float>(first - std::round(first)),
             static_cast<float>(std::log10(2.0) / interval), steps},
            {decades != 0 ? static_cast<float>(interval / decades) : 0, dark_from, dark_to}};
  }
  const double per_value = std::abs(field.scale) / interval;
  if (!(per_value >= kLeastPerValue && per_value <= kMostPerValue)) return none;
  const double range = high - low, first = std::remainder(field.offset, interval) / interval;
  return {
      {static_cast<float>(field.scale / interval), static_cast<float>(first), 0, steps},
      {range != 0 ? static_cast<float>(std::min(interval / range, 1e6)) : 0, dark_from, dark_to}};
}

}  // namespace isosplat::render
