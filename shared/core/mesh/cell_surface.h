#pragma once

#include <array>
#include <cstdint>

#include "shared/core/mesh/cell_edges.h"
#include "shared/core/mesh/loop_triangles.h"

namespace isosplat {

/// The surface of a cell with these signs. Null if a face or the interior is ambiguous.
const CellTriangles* simple_cell_surface(CornerSigns signs);

/// The surface of any cell. `values`: those of the corners, minus the isovalue; corners above 0 are
/// above the isovalue. The surface has the topology of the trilinear function's isosurface: on
/// faces by the asymptotic decider (G. M. Nielson, B. Hamann, "The asymptotic decider", 1991), so
/// that cells that share a face fit together, and inside by interior_regions(), which finds
/// tunnels. Vertices are on cut edges; see loop_triangles.h for additional ones.
const CellTriangles& cell_surface(const std::array<double, 8>& values);

}  // namespace isosplat
