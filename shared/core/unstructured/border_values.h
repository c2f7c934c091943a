#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <vector>

#include "shared/core/unstructured/linear_fit.h"
#include "shared/core/unstructured/mesh.h"

namespace isosplat {

/// A grid cell on the border of a mesh is divided into so many parts along each axis.
inline constexpr int32_t kBorderParts = 4;

/// The values at the corners of a grid cell on the border of a mesh: corners outside have the
/// values of the linear function that fits the inside best. Nothing if less than half of the cell's
/// parts have their centre inside. `corners`: the values at corners that are inside. `find`:
/// returns the value at a point as std::optional<double>, which is empty outside.
template <class Find>
std::optional<std::array<double, 8>> border_values(
    const Box& box, const std::array<std::optional<double>, 8>& corners, const Find& find) {
  const Vec3d size = box.high - box.low;
  std::vector<SamplePoint> inside;
  constexpr int32_t kParts = kBorderParts;
  constexpr size_t kHalf = kParts * kParts * kParts / 2;
  const bool are_known =
      std::all_of(corners.begin(), corners.end(), [](const auto& corner) { return !!corner; });
  for (int32_t i = 0; i < kParts * kParts * kParts; ++i) {
    if (are_known && inside.size() == kHalf) break;  // no other value is needed
    const Vec3d f =
        Vec3d{i % kParts + 0.5, i / kParts % kParts + 0.5, i / (kParts * kParts) + 0.5} *
        (1.0 / kParts);
    const std::optional<double> found =
        find(box.low + Vec3d{size.x * f.x, size.y * f.y, size.z * f.z});
    if (found) inside.push_back({f, *found});
  }
  if (inside.size() < kHalf) return std::nullopt;
  const LinearFunction outside = linear_fit(inside);
  std::array<double, 8> values{};
  for (int32_t i = 0; i < 8; ++i) {
    const auto k = static_cast<size_t>(i);
    values[k] = corners[k].value_or(outside({i & 1 ? 1.0 : 0, i & 2 ? 1.0 : 0, i & 4 ? 1.0 : 0}));
  }
  return values;
}

}  // namespace isosplat
