#pragma once

#include <vector>

#include "shared/core/base/status.h"
#include "shared/core/mesh/mesh_part.h"

namespace isosplat {

/// A side of a cap: the reverse of an edge that only one triangle of the mesh has.
struct CapSide {
  uint32_t from = 0, to = 0;  ///< vertices of the mesh
};

/// Fills a plane cut of a mesh with triangles. They use each side once, in its direction, and no
/// other vertices. sides: loops, counter-clockwise around the solid seen from outside. u, v:
/// perpendicular unit vectors in the plane; u × v points outwards. Errors: invalid_argument (the
/// sides form no loops, since the mesh has other holes).
Result<void> append_cap(MeshPart& mesh, std::vector<CapSide> sides, Vec3d u, Vec3d v);

/// The error of a mesh with other holes than the cuts.
Error not_closable();

}  // namespace isosplat
