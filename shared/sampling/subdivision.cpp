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

void subdivide_cell(const CellCorners& corners, Subdivision parts, std::vector<Sample>& samples) {
  const Trilinear f(corners);
  const Vec3f size{1.0f / static_cast<float>(parts.x), 1.0f / static_cast<float>(parts.y),
                   1.0f / static_cast<float>(parts.z)};
  for (int32_t k = 0; k < parts.z; ++k) {
    for (int32_t j = 0; j < parts.y; ++j) {
      for (int32_t i = 0; i < parts.x; ++i) {
        const Vec3f low{static_cast<float>(i) * size.x, static_cast<float>(j) * size.y,
                        static_cast<float>(k) * size.z};
        // A trilinear function takes its extrema over a box at the box's corners.
        float min = HUGE_VALF, max = -HUGE_VALF;
        for (int c = 0; c < 8; ++c) {
          const Vec3f corner{c & 1 ? low.x + size.x : low.x, c & 2 ? low.y + size.y : low.y,
                             c & 4 ? low.z + size.z : low.z};
          const float value = f.at(corner).value;
          min = std::min(min, value);
          max = std::max(max, value);
        }
        const Vec3f centre = low + size * 0.5f;
        const auto [value, gradient] = f.at(centre);
        samples.push_back({centre,
                           value,
                           gradient,
                           {static_cast<Code>(std::clamp(std::floor(min), 0.0f, 65535.0f)),
                            static_cast<Code>(std::clamp(std::ceil(max), 0.0f, 65535.0f))}});
      }
    }
  }
}

}  // namespace isosplat
