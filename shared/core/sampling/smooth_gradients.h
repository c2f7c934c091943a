#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <unordered_map>

#include "shared/core/grid/grid.h"
#include "shared/core/sampling/trilinear.h"

namespace isosplat {

/// The share of a cell in the smooth gradient at a point.
struct CornerGradients {
  Vec3f gradient;    ///< Σ over corners: hat function × gradient there; quantized values per cell
  float weight = 0;  ///< Σ of the hat functions
};

/// The share of a cell at p, relative to corner 0, in cells. A corner's hat function is 1 at the
/// corner and falls to 0 at the neighbouring lattice points: the share is 0 at a distance of one
/// cell or more from the cell.
CornerGradients corner_gradients(const std::array<float, 8>& corners, Vec3f p);

/// Smooth gradients at points near a set of cells: the sums of the cells' shares. They are
/// continuous, within a level and where levels meet. If all eight cells around each of the eight
/// lattice points of a cell are in the set, the gradient in this cell is that of central
/// differences at the voxels, interpolated trilinearly. The renderer computes the same for pixels
/// (shared/render, decision 22).
class SmoothGradients {
 public:
  /// Adds a cell, or replaces it. `cell`: index in its level.
  void add(uint32_t level, Index3 cell, const std::array<float, 8>& corners);

  /// The direction of the gradient at a position in voxels of level 0, as a row vector along the
  /// grid's axes; its length has no meaning. Zero where no cell has a share. Where levels meet,
  /// each cell is weighted by the inverse of its volume.
  Vec3d at(Vec3d position) const;

 private:
  using Cells = std::unordered_map<uint64_t, std::array<float, 8>>;
  std::map<uint32_t, Cells> levels_;
};

}  // namespace isosplat
