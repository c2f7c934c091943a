#pragma once

#include "shared/core/base/vec3.h"
#include "shared/core/sampling/packed_sample.h"
#include "shared/core/sampling/sample_neighbours.h"

namespace isosplat::render {

// The same computations as in shaders/thin.glsl: how to draw coarse cells that contain structures
// thinner than a cell. That file states the reasons.

/// The quantized isovalue at which the surface of an active coarse cell is drawn. If it is not
/// within the range of the corners, the cell is drawn as a thin_box().
float thickened_isovalue(const UnpackedSample& cell, float quantized_isovalue);

/// Whether the trilinear function of the corners has this isovalue.
bool is_within_corners(const UnpackedSample& cell, float quantized_isovalue);

/// A box in a cell, each coordinate 0 to 1, and the axes on which it spans the cell.
struct ThinBox {
  Vec3d low, high;
  std::array<bool, 3> spanned{};
};

/// The box of the structure in a coarse cell. voxel: side of a voxel of level 0, in cells.
ThinBox thin_box(const UnpackedSample& cell, NeighbourBits neighbours, float quantized_isovalue,
                 double voxel);

}  // namespace isosplat::render
