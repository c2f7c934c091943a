#pragma once

#include "shared/core/sampling/trilinear.h"

namespace isosplat {

/// A point of a cell from which the isosurface can be reached (paper, section 4). Positions and
/// gradients are in cell units of the sample's level: x, y, z ∈ [0, 1] inside the cell. VolumeGrid
/// converts them to the world.
struct Sample {
  Vec3f position;         ///< in the cell
  float value = 0;        ///< the trilinear interpolant there, in quantized values
  Vec3f gradient;         ///< quantized values per cell
  CellInterval interval;  ///< of the sample's cell
};

/// The sample at the cell's centre.
inline Sample centre_sample(const CellCorners& corners, CellInterval interval) {
  const Vec3f centre{0.5f, 0.5f, 0.5f};
  const auto [value, gradient] = Trilinear(corners).at(centre);
  return {centre, value, gradient, interval};
}

}  // namespace isosplat
