#pragma once

#include "shared/core/base/matrix3.h"
#include "shared/core/codec/chunk_codec.h"
#include "shared/core/grid/grid.h"

namespace isosplat {

/// Selects the cells whose centres lie in a box: low ≤ centre < high along each axis, so that
/// adjacent boxes share no cell, and together contain all cells. A surface ends at faces of cells.
class CellRegion {
 public:
  /// `low`, `high`: in the world.
  static CellRegion in_world(const VolumeGrid& grid, Vec3d low, Vec3d high);
  /// `low`, `high`: in voxels of level 0, along the axes of the grid.
  static CellRegion in_grid(Vec3d low, Vec3d high);

  /// Whether the cell is in the region. `cell`: its low corner, in cells of the level.
  bool contains(Index3 cell, uint32_t level) const;

  /// Whether any of these cells may be in the region: [first, first + count) of a level.
  bool may_contain(Index3 first, Index3 count, uint32_t level) const;

  /// Removes the cells of a block that are not in the region. `origin`: the block's low corner in
  /// cells of the level.
  void keep(DecodedCells& cells, Index3 origin, uint32_t level) const;

 private:
  CellRegion(const Matrix3d& edges, Vec3d origin, Vec3d low, Vec3d high)
      : edges_(edges), origin_(origin), low_(low), high_(high) {}

  Matrix3d edges_;  ///< from voxels to the axes of the box
  Vec3d origin_, low_, high_;
};

}  // namespace isosplat
