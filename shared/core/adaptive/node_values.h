#pragma once

#include <optional>

#include "shared/core/adaptive/adaptive_grid.h"

namespace isosplat {

/// A leaf cell of an adaptive grid.
struct LeafCell {
  uint32_t level = 0;
  Index3 cell;
};

/// The leaf cell that touches a node of a level in an octant (bit 0: towards greater x, bit 1: y,
/// bit 2: z). Nothing where there is no value. The grid is resolved.
std::optional<LeafCell> leaf_around(const AdaptiveGrid& grid, uint32_t level, Index3 node,
                                    int32_t octant);

/// The value at a node of a level: of the function that is trilinear in each leaf cell, and
/// continuous over the borders of levels with any ratio.
///
/// Let c be the coarsest level of the leaf cells that touch the node. If the node is one of level
/// c, its value is the average of these cells, weighted by the inverse of their edges: linear
/// functions are exact, except beside holes and the border of the domain. With Centring::nodes, it
/// is the value of the finest patch. Otherwise the node is a hanging one: it lies on a face or an
/// edge of a cell of level c, and has the value that this cell interpolates there. A bilinear
/// function on a face is the same bilinear function on each part of the face, so both sides agree.
///
/// Requires a leaf cell of this level, or of a coarser one, that touches the node.
double node_value(const AdaptiveGrid& grid, uint32_t level, Index3 node);

}  // namespace isosplat
