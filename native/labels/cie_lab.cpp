#include "native/labels/cie_lab.h"

#include <algorithm>
#include <cmath>

namespace isosplat {
namespace {

/// The inverse of the function f of CIE 15, 8.2.1.
double from_lightness(double f) {
  constexpr double kDelta = 6.0 / 29;
  return f > kDelta ? f * f * f : 3 * kDelta * kDelta * (f - 4.0 / 29);
}

/// The transfer function of IEC 61966-2-1.
double encode(double linear) {
  const double c = std::clamp(linear, 0.0, 1.0);
  return c <= 0.0031308 ? 12.92 * c : 1.055 * std::pow(c, 1 / 2.4) - 0.055;
}

}  // namespace

std::array<float, 3> srgb_of_cie_lab(const std::array<double, 3>& lab) {
  const double y = (lab[0] + 16) / 116;
  // X, Y and Z for the white point D50.
  const double xyz[3] = {0.96422 * from_lightness(y + lab[1] / 500), from_lightness(y),
                         0.82521 * from_lightness(y - lab[2] / 200)};
  // Bradford's adaptation to D65, and then the primaries of sRGB (B. Lindbloom).
  constexpr double kMatrix[3][3] = {{3.1338561, -1.6168667, -0.4906146},
                                    {-0.9787684, 1.9161415, 0.0334540},
                                    {0.0719453, -0.2289914, 1.4052427}};
  std::array<float, 3> srgb{};
  for (size_t i = 0; i < 3; ++i) {
    double linear = 0;
    for (size_t k = 0; k < 3; ++k) linear += kMatrix[i][k] * xyz[k];
    srgb[i] = static_cast<float>(encode(linear));
  }
  return srgb;
}

}  // namespace isosplat
