#pragma once

#include <vector>

#include "tests/evidence/ewa/checker.h"

namespace isosplat {

/// The luminance of the bright and of the dark squares, and the mean over the pattern.
struct CheckerLevels {
  double dark = 0, bright = 0, mean = 0;
};
CheckerLevels levels_of(const Checker& checker, const render::Camera& camera);

/// Alias of a picture of the checker: the root mean square of its difference from the pattern's
/// mean, divided by half the pattern's contrast. Only those pixels count in which the image can
/// show no frequency of the pattern: each wave of its spectrum up to order 15 has more than ½ cycle
/// per px along x or y. An ideal picture shows the mean there. Pixels within 4 px of the plane's
/// end are left out. `pixels` (may be null): the number of counted pixels.
double checker_alias(const Luminance& picture, const Checker& checker, const ImagePlane& image,
                     const CheckerLevels& levels, size_t* pixels = nullptr);

/// Amplitude of the pattern's two lowest waves in a picture, where they have `low` to `high` cycles
/// per px: the sum of luminance times the conjugate wave. `per_px`: squares of the picture per
/// pixel of the image along each axis.
double wave_amplitude(const Luminance& picture, int per_px, const Checker& checker,
                      const ImagePlane& image, const CheckerLevels& levels, double low,
                      double high);

/// Width of the pattern's edges in a picture of the plane seen from its front, in px. The mean
/// luminance, as a function of the distance from the edge, is computed from the pixels of slanted
/// edges (as in ISO 12233). The width is the distance between 10 and 90 % of its step from dark to
/// bright.
double edge_width(const Luminance& picture, int per_px, const Checker& checker,
                  const ImagePlane& image, const CheckerLevels& levels);

}  // namespace isosplat
