#pragma once

#include "shared/core/preprocess/coarse_levels.h"

namespace isosplat {

/// How voxels state distances from the surface at the only isovalue: quantized value − isovalue is
/// the signed distance in steps, positive inside, limited to −limit … limit. The limit is at least
/// one voxel.
struct DistanceSteps {
  int32_t per_voxel;
  int32_t limit;
};

/// The distances of coarse levels, in voxels of their own level.
inline constexpr DistanceSteps kCoarseDistances{8, 15};

/// The coarse levels of a store for one isovalue (Layer::only_isovalue) whose voxels are distances
/// from its surface: values of 8 bits, none missing. Coarse voxels are distances too, so that each
/// level has a closed surface of its own, and thin structures remain in it:
///
/// - Near the surface, a coarse voxel is the [1 2 1]³ average of the finer ones. A pair of opposite
///   neighbours counts as the voxel between them if one of the pair is at the limit.
/// - At a voxel at the limit, the distance is the shortest one over the voxels that are at most two
///   voxels away along each axis.
/// - Structures of less than 9/8 voxels from the middle to the surface are thickened to that: their
///   sheets could fall between coarse voxels.
/// - If a voxel inside would still have no coarse voxel inside around it, as in narrow tubes, the
///   one that is nearest to the inside moves inside.
/// - Coarse voxels on the faces of the volume are outside.
///
/// A coarse cell is active if it contains the surface of its own level or of a finer one. All
/// intervals are as wide as the codec can code for free. So the corners alone determine the
/// surface.
class DistanceLevels : public CoarseLevels {
 public:
  /// finest: the distances of level 0.
  explicit DistanceLevels(DistanceSteps finest) : finest_(finest) {}

  void coarsen_voxels(const Layer& layer, const GatheredBlock& block,
                      const CoarserLayer& coarser) const override;
  void set_intervals(const Layer& layer, GatheredBlock& block) const override;
  bool corners_suffice() const override { return true; }

 private:
  DistanceSteps finest_;
};

}  // namespace isosplat
