#pragma once

#include <vector>

#include "shared/core/base/vec3.h"

namespace isosplat {

/// The plane of a face.
struct FacePlane {
  Vec3d normal;         ///< of unit length, or 0
  double distance = 0;  ///< of a point from it, the same point for all planes
};

/// Planes look at each other if the cosine between their normals is below.
inline constexpr double kOpposite = -0.7;

/// Whether two planes look at each other over a gap: the sum of their distances, which is the width
/// of the gap, is not negative. (It is negative for the two sides of a thin sheet.) A search tree
/// of the normals makes it O(n log n) for planes with few directions, as those of walls. Reorders
/// `planes`.
bool are_some_opposite(std::vector<FacePlane>& planes);

}  // namespace isosplat
