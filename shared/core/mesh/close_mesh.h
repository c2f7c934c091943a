#pragma once

#include "shared/core/base/status.h"
#include "shared/core/mesh/mesh_part.h"

namespace isosplat {

/// Closes an isosurface at the faces of the box in which it was computed, where values are above
/// the isovalue: each edge then belongs to two triangles, in opposite directions. mesh: all
/// triangles of a MeshAssembly in a box of whole cells, of a BlockMesher that keeps vertices off
/// lattice points; triangles are counter-clockwise seen from the side of lower values. low, high:
/// the faces of the box, in the mesh's coordinates, exactly. An empty mesh stays empty, also if the
/// whole box is above. Fields have no values at the corners of the box. Errors: invalid_argument
/// (the mesh has other holes).
Result<void> close_at_box(MeshPart& mesh, Vec3d low, Vec3d high);

/// Whether each edge is used as often in one direction as in the other. Compares sums of 64-bit
/// hashes of edges, so an open mesh passes with a probability of 2⁻⁶⁴.
bool is_closed(const MeshPart& mesh);

}  // namespace isosplat
