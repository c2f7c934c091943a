#include "shared/render/settings/plane.h"

#include <cmath>

namespace isosplat::render {

std::optional<Plane> unit_plane(const Plane& plane) {
  const auto& [n, offset] = plane;
  const double size = std::hypot(n.x, n.y, n.z);
  const Plane unit{n * (1 / size), offset / size};
  const bool is_plane = std::isfinite(dot(unit.normal, unit.normal)) && std::isfinite(unit.offset);
  return size > 0 && is_plane ? std::optional(unit) : std::nullopt;
}

}  // namespace isosplat::render
