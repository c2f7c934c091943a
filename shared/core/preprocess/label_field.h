#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "shared/core/preprocess/distance_levels.h"
#include "shared/core/preprocess/label_volume.h"

namespace isosplat {

/// The margin in voxels between the bounding box of a label and its LabelBox on each side.
inline constexpr int32_t kLabelFieldReach = 2;

inline constexpr uint8_t kLabelFieldInside = 62;
inline constexpr uint8_t kLabelFieldIsovalue = 31;

/// The field's steps per voxel.
inline constexpr int kLabelFieldSteps = 16;
inline constexpr DistanceSteps kLabelFieldDistances{kLabelFieldSteps, kLabelFieldIsovalue};

/// The field whose isosurface at kLabelFieldIsovalue is the smooth surface of one label. Voxels of
/// the label are above the isovalue and all others below, so the surface crosses the lattice edges
/// between the label and the rest, and no other edge.
///
/// The field is a signed distance in steps of 1/16 voxel, limited to 31 steps, so that it has a
/// slope in every cell that the surface crosses. Steps of 1/12 make stores 5 % smaller, but sheets
/// of two voxels visibly rough: their normals differ by up to 5.8 degrees instead of 3.8. The
/// distance has these parts:
/// 1. label_distance.h: the distance from the border of the voxels;
/// 2. label_smoothing.h: a low-pass filter that keeps each voxel on its side of the surface;
/// 3. label_balance.h: a shift, so that the surface encloses the volume of the voxels;
/// 4. the filter and the shift again: keeping each voxel on its side has bent the surface.
/// Each part is odd: swapping the label and the rest negates the field. So where two labels touch
/// and no third one is within about 30 voxels, they share their border exactly. Near a third label,
/// their surfaces still cross the same lattice edges, but are apart or overlap: by 0.2 voxels on
/// average up to three voxels from the third label, by at most 0.63, and by at most 0.13 from
/// twelve voxels on (the test MismatchAtTripleLines measures it on a ball that is cut in two).
///
/// Boxes above 218 voxels along an axis are computed in tiles, with 32 voxels around each. So the
/// field depends on the volume, the label and the box alone.
class LabelField {
 public:
  /// Borrows the volume. `box` may lie anywhere, also outside of the volume. For a closed surface,
  /// it must contain the bounding box of the label and one voxel around it.
  LabelField(const LabelVolume& volume, uint16_t label, const LabelBox& box);

  /// Computes the slices first to first + count − 1 of the box into `out`: box.size.x · box.size.y
  /// · count values, x fastest. Caches the neighbouring slices, so that a sequence of calls for
  /// consecutive slices is fast.
  void compute(int32_t first, int32_t count, std::span<uint8_t> out);

  /// Memory of the largest compute(), in bytes.
  uint64_t memory_bytes() const;

 private:
  size_t slice_voxels() const;
  void compute_band(int32_t number);
  void compute_tile(Index3 first, Index3 end);

  LabelVolume volume_;
  uint16_t label_;
  LabelBox box_;
  int32_t band_slices_;          ///< the greatest number of slices that are computed together
  int32_t bands_;                ///< along z
  int32_t first_ = 0, end_ = 0;  ///< slices of the box in band_
  std::vector<uint8_t> band_;
};

}  // namespace isosplat
