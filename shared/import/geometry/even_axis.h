#pragma once

#include <cmath>
#include <optional>
#include <vector>

namespace isosplat::import {

struct EvenAxis {
  double origin = 0, spacing = 1;
};

/// The origin and spacing of positions that are evenly spaced, up to 0.01 of the spacing: they are
/// often 32-bit floats. Nothing for others, and for less than two.
inline std::optional<EvenAxis> even_axis(const std::vector<double>& positions) {
  if (positions.empty()) return std::nullopt;
  EvenAxis axis{positions.front(),
                (positions.back() - positions.front()) / static_cast<double>(positions.size() - 1)};
  if (!std::isfinite(axis.origin) || !std::isfinite(axis.spacing) || axis.spacing == 0) {
    return std::nullopt;
  }
  for (size_t i = 0; i < positions.size(); ++i) {
    const double expected = axis.origin + static_cast<double>(i) * axis.spacing;
    if (!(std::abs(positions[i] - expected) <= 0.01 * std::abs(axis.spacing))) return std::nullopt;
  }
  return axis;
}

}  // namespace isosplat::import
