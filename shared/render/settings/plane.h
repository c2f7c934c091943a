#pragma once

#include <optional>

#include "shared/core/base/vec3.h"

namespace isosplat::render {

/// The plane dot(normal, position) = offset. Its owner states its frame, and whether it stands for
/// the half-space dot(normal, position) ≥ offset.
struct Plane {
  Vec3d normal{0, 0, 1};
  double offset = 0;

  friend bool operator==(const Plane&, const Plane&) = default;
};

/// The same plane with a normal of length 1; nothing if it is no plane, or if its normal is too
/// long or too short to compute with.
std::optional<Plane> unit_plane(const Plane& plane);

}  // namespace isosplat::render
