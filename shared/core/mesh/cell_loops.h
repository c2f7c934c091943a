#pragma once

#include <cstdint>
#include <vector>

#include "shared/core/mesh/cell_edges.h"

namespace isosplat {

/// Cut edges in the order in which a loop passes them, counter-clockwise seen from the side of
/// lower values.
using CellLoop = std::vector<CellEdge>;

/// Bit f: the corners of face f have alternating signs.
uint32_t ambiguous_faces(CornerSigns signs);

/// The loops in which the surface meets the cell's faces. Each cut edge is in exactly one of them.
/// joined: bit f: the upper corners of the ambiguous face f are connected; bits of other faces have
/// no meaning.
std::vector<CellLoop> cell_loops(CornerSigns signs, uint32_t joined);

}  // namespace isosplat
