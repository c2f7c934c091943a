#include "shared/sampling/subdivision.h"

#include <algorithm>
#include <cmath>

namespace isosplat {

Subdivision anisotropic_subdivision(Vec3d spacing, int32_t limit) {
  const double smallest = std::min({spacing.x, spacing.y, spacing.z});
  const auto parts = [&](double s) {
    return static_cast<int32_t>(std::clamp(std::round(s / smallest), 1.0, double(limit)));
  };
  return {parts(spacing.x), parts(spacing.y), parts(spacing.z)};
}

Subdivision interval_subdivision(const CellCorners& corners, float width, int32_t limit) {
  std::vector<Sample> parts;
  int32_t n = 1;
  for (; 2 * n <= limit; n *= 2) {
    parts.clear();
    subdivide_cell(corners, {n, n, n}, parts);
    const auto narrow = [width](const Sample& part) {
      return static_cast<float>(part.interval.max - part.interval.min) <= width;
    };
    if (std::all_of(parts.begin(), parts.end(), narrow)) break;
  }
  return {n, n, n};
}

void subdivide_cell(const CellCorners& corners, Subdivision parts, std::vector<Sample>& samples) {
  const Trilinear f(corners);
  const CellInterval whole = corner_interval(corners);
  // Exact at both ends of the cell, and the same for both parts that meet.
  const auto cut = [](int32_t i, int32_t n) {
    return static_cast<float>(i) / static_cast<float>(n);
  };
  for (int32_t k = 0; k < parts.z; ++k) {
    for (int32_t j = 0; j < parts.y; ++j) {
      for (int32_t i = 0; i < parts.x; ++i) {
        const Vec3f low{cut(i, parts.x), cut(j, parts.y), cut(k, parts.z)};
        const Vec3f high{cut(i + 1, parts.x), cut(j + 1, parts.y), cut(k + 1, parts.z)};
        // A trilinear function takes its extrema over a box at the box's corners.
        float min = HUGE_VALF, max = -HUGE_VALF;
        for (int c = 0; c < 8; ++c) {
          const Vec3f corner{c & 1 ? high.x : low.x, c & 2 ? high.y : low.y,
                             c & 4 ? high.z : low.z};
          const float value = f.at(corner).value;
          min = std::min(min, value);
          max = std::max(max, value);
        }
        const Vec3f centre = (low + high) * 0.5f;
        const auto [value, gradient] = f.at(centre);
        // Rounding must not make a part active where the cell is not.
        const auto code = [whole](float v) {
          return static_cast<Code>(std::clamp(v, float(whole.min), float(whole.max)));
        };
        samples.push_back({centre, value, gradient, {code(std::floor(min)), code(std::ceil(max))}});
      }
    }
  }
}

}  // namespace isosplat
