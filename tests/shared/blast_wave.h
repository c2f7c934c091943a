#pragma once

#include <cmath>
#include <functional>
#include <vector>

#include "tests/shared/adaptive_fixture.h"

// A blast wave on an adaptive grid, as block-structured codes (FLASH, for example) write it.
namespace isosplat::adaptive_test {

/// The density at a position in [−1, 1]³: a shock of the form of a dented sphere.
inline double blast_density(Vec3d p) {
  const double r = std::sqrt(p.x * p.x + p.y * p.y + p.z * p.z) + 1e-9;
  const double dents = std::sin(4 * std::atan2(p.y, p.x)) * std::cos(3 * p.z / r);
  const double d = r - 0.6 - 0.06 * dents;
  return 2 - 1.5 * std::tanh(d / 0.09) + std::exp(-d * d / 0.02);
}

/// The blast wave with cells of `levels` levels, ratio 2: level 0 has 32³ cells. Each patch has 8³
/// cells. A patch near the shock is refined, to finer levels towards greater x, so that the shock
/// crosses the borders of all levels.
inline Case blast_wave(size_t levels) {
  Case made;
  made.cells = {32, 32, 32};
  made.ratios.assign(levels - 1, 2);
  const std::function<void(size_t, Index3)> add = [&](size_t level, Index3 block) {
    const double edge = 1.0 / made.edge(0, level), width = 2 * edge / 32;  // of a cell
    const auto centre = [&](Index3 cell) {
      return Vec3d{(cell.x + 0.5) * width - 1, (cell.y + 0.5) * width - 1,
                   (cell.z + 0.5) * width - 1};
    };
    Patch patch{static_cast<uint32_t>(level), {block * 8, block * 8 + Index3{8, 8, 8}}, {}};
    for_each_index({8, 8, 8},
                   [&](Index3 i) { patch.values.push_back(blast_density(centre(block * 8 + i))); });
    const auto [low, high] = std::minmax_element(patch.values.begin(), patch.values.end());
    const Vec3d middle = centre(block * 8 + Index3{4, 4, 4});
    const bool is_near = *low < 2.8 && *high > 1.2;
    const bool is_fine =
        (middle.x + 1) / 2 * static_cast<double>(levels) > static_cast<double>(level) + 0.7;
    made.patches.push_back(std::move(patch));
    if (level + 1 == levels || !is_near || !is_fine) return;
    for_each_index({2, 2, 2}, [&](Index3 o) { add(level + 1, block * 2 + o); });
  };
  for_each_index({4, 4, 4}, [&](Index3 block) { add(0, block); });
  return made;
}

}  // namespace isosplat::adaptive_test
