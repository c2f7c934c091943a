#pragma once

#include <array>
#include <vector>

#include "shared/core/base/status.h"
#include "shared/core/grid/grid.h"
#include "shared/core/mesh/cell_region.h"
#include "shared/core/mesh/clip_mesh.h"

namespace isosplat {

/// A part of a volume: within its outermost voxels, and within half-spaces.
class SolidRegion {
 public:
  /// The whole volume, at a level.
  SolidRegion(const VolumeGrid& grid, uint32_t level);

  /// Limits the region to a half-space of the world. Errors: invalid_argument (the normal is zero,
  /// or a number is not finite or too large).
  Result<void> clip(const HalfSpace& half_space);
  /// Limits it to a box of the world, or of voxels of level 0. Errors: invalid_argument (a corner
  /// is NaN).
  Result<void> clip_to_box(Vec3d low, Vec3d high);
  Result<void> clip_to_voxels(Vec3d low, Vec3d high);

  /// How far vertices have to be from lattice points: BlockMesher::keep_off_lattice_points.
  static constexpr float kLeastDistance = 0x1p-14f;

  /// The cells that have to be meshed: a box of whole cells around the region.
  CellRegion cells() const;

  /// Turns the mesh of these cells into the surface of the solid in the region: the part with
  /// values above the isovalue. It is closed, in the world, and has no unused vertices. Meshes are
  /// those of MeshAssembly with lattice_grid(), and of a BlockMesher that keeps vertices off
  /// lattice points. Where a cut is, vertices have the normals of the surface. Values of fields are
  /// known on the isosurface and its edges; at other vertices of cuts they are missing.
  /// is_category: see clip_closed(). Errors: invalid_argument (the mesh has holes, from missing
  /// voxels).
  Result<void> close(MeshPart& mesh, const std::vector<bool>& is_category = {}) const;

 private:
  void clip_voxels(Vec3d normal, double offset);
  void shrink(int axis, double low, double high);

  VolumeGrid grid_;
  double cell_size_;
  std::array<double, 3> low_, high_;  ///< of the cells, in voxels of level 0
  std::vector<HalfSpace> cuts_;       ///< in voxels of level 0
};

/// A grid whose world coordinates are voxels.
VolumeGrid lattice_grid(Index3 voxels);

}  // namespace isosplat
