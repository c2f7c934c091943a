#pragma once

#include <vector>

#include "shared/core/base/status.h"
#include "shared/core/mesh/mesh_part.h"

namespace isosplat {

/// The points with normal · point ≥ offset.
struct HalfSpace {
  Vec3d normal;  ///< any length > 0
  double offset = 0;
};

/// Cuts off what is outside of a half-space, and closes the cut. mesh: closed, with coordinates in
/// voxels; vertices that are no longer used stay in it. half_space: finite, with a normal of unit
/// length. Vertices of the cut are between the ends of edges, at least 2⁻¹⁴ voxels from them if the
/// edge is long enough: so those of different edges differ. is_cap: for each triangle, whether it
/// closes a cut; changed as the triangles are. Values of fields are interpolated on the edges of
/// other triangles; inside of caps they are missing. is_category: for each field, whether it has
/// the value of the edge's nearer end instead; empty: no field has. Errors: invalid_argument (the
/// mesh is not closed).
Result<void> clip_closed(MeshPart& mesh, std::vector<bool>& is_cap, const HalfSpace& half_space,
                         const std::vector<bool>& is_category = {});

}  // namespace isosplat
