#pragma once

#include "shared/core/adaptive/adaptive_grid.h"

namespace isosplat {

/// Chooses the cells of the lattice of each level (CellBrick::drawn), so that each point of a leaf
/// cell is in a drawn cell of exactly one level.
///
/// A lattice leaves out a cell by a missing voxel at one of its corners. These are the leaf cells,
/// except where a cell that is not drawn lies between drawn cells that need all eight corners, such
/// as a single refined cell. Then the drawn cells around one of these corners are drawn on the next
/// finer level instead, with the values that they interpolate: the function stays the same. If
/// there is no finer level, one of ratio 2 is added. The grid is resolved. Errors: out_of_memory.
Result<void> choose_drawn_cells(AdaptiveGrid& grid);

}  // namespace isosplat
