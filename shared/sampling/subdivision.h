#pragma once

#include <vector>

#include "shared/sampling/sample.h"

namespace isosplat {

/// Into how many parts a cell is cut along each axis before a sample is placed at each part's
/// centre (paper, section 4): 1 where one sample represents the isosurface in the cell.
struct Subdivision {
  int32_t x = 1, y = 1, z = 1;
};

/// The subdivision that evens out anisotropic spacing: along each axis, how often the smallest
/// spacing fits, at most `limit` (≥ 1).
Subdivision anisotropic_subdivision(Vec3d spacing, int32_t limit);

/// The subdivision by which no part's interval is wider than `width` codes: the smallest power of
/// two along all axes that does it, at most `limit` (≥ 1).
Subdivision interval_subdivision(const CellCorners& corners, float width, int32_t limit);

/// Samples at the centres of the parts of one cell, x fastest. The interval of each is that of its
/// part's eight corners, rounded outwards to codes within the cell's interval: the parts' active
/// tests together miss nothing of the cell's isosurface, and none holds where the cell's does not.
/// Appends x · y · z samples to `samples`.
void subdivide_cell(const CellCorners& corners, Subdivision parts, std::vector<Sample>& samples);

}  // namespace isosplat
