#include "native/labels/label_colours.h"

#include <algorithm>
#include <cmath>

namespace isosplat {
namespace {

constexpr double kGoldenAngle = 2.399963229728653;
constexpr double kTurn = 6.283185307179586;

/// Lightness and chroma. Consecutive values take turns. All hues of these tones are within sRGB,
/// except for the deepest blues, whose components are clamped.
constexpr std::array<std::array<double, 2>, 3> kTones{{{0.72, 0.13}, {0.56, 0.14}, {0.84, 0.09}}};

float encoded(double linear) {
  const double in = std::clamp(linear, 0.0, 1.0);
  return static_cast<float>(in <= 0.0031308 ? 12.92 * in : 1.055 * std::pow(in, 1 / 2.4) - 0.055);
}

double cubed(double value) {
  return value * value * value;
}

}  // namespace

std::array<float, 3> label_colour(int64_t value) {
  const auto number = static_cast<uint64_t>(value);
  const auto [lightness, chroma] = kTones[number % kTones.size()];
  const double hue = std::fmod(static_cast<double>(number % 65536) * kGoldenAngle, kTurn);
  const double a = chroma * std::cos(hue), b = chroma * std::sin(hue);
  const double l = cubed(lightness + 0.3963377774 * a + 0.2158037573 * b);
  const double m = cubed(lightness - 0.1055613458 * a - 0.0638541728 * b);
  const double s = cubed(lightness - 0.0894841775 * a - 1.2914855480 * b);
  return {encoded(4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s),
          encoded(-1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s),
          encoded(-0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s)};
}

}  // namespace isosplat
