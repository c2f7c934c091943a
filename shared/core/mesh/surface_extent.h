#pragma once

#include "shared/core/grid/grid.h"
#include "shared/core/mesh/block_mesh.h"

namespace isosplat {

/// Sums over the triangles of an isosurface: its area, and the volume that it encloses with the
/// faces of the grid. Add the mesh of every block of one level, in any order.
///
/// The volume follows by Gauss's theorem from the flux of the field (x, 0, 0), in voxels. Only the
/// face where x is largest has a flux besides the surface's: the area, on this face, of the region
/// above the isovalue. Green's theorem computes it from the boundary of the surface on the face. If
/// the last voxel is above, the volume of the whole grid is added. It is on the same side as the
/// last corner of the last active cell (by z, then y, then x), since all cells after it are
/// inactive.
///
/// Triangles are flatter than the surface: where its radius of curvature is r cells, about 0.6 / r²
/// of the volume is lost, and at most 1 / r² of area and volume.
class SurfaceExtent {
 public:
  /// `grid`: of the volume; the level is 0. `lowest`: the volume's smallest value. If there is no
  /// surface, it determines on which side the whole volume is.
  SurfaceExtent(const VolumeGrid& grid, float quantized_isovalue, QuantizedValue lowest);

  /// Adds a block's cells and their mesh. `origin`: the block's low corner in cells.
  void add(const DecodedCells& cells, const BlockMesh& mesh, Index3 origin);

  /// World units².
  double area() const { return area_; }
  /// The volume of the region above the isovalue, world units³. Meaningless if the grid has missing
  /// voxels, where the surface has holes.
  double volume_above() const;
  /// The volume of the whole grid, between the centres of its outermost voxels, world units³.
  double grid_volume() const { return voxels_ * cell_volume_; }

 private:
  Matrix3d edges_;
  double cell_volume_, voxels_;
  Vec3d last_;  // the largest coordinates, in voxels
  float isovalue_;
  uint64_t last_active_ = 0;  // the order of the last active cell, + 1; 0: none
  bool is_last_above_;        // the last voxel, so far
  double area_ = 0, flux_ = 0;
};

}  // namespace isosplat
