#pragma once

#include <optional>
#include <span>
#include <vector>

#include "shared/core/grid/grid.h"
#include "shared/core/sampling/packed_sample.h"
#include "shared/render/frame/frame.h"
#include "shared/render/pick/surface_pick.h"
#include "shared/render/settings/render_settings.h"

namespace isosplat::render {

/// The ray through a position in the image, in voxels of level 0: origin + t · direction. t is the
/// distance in world units from the plane through the eye, along the viewing direction.
struct PickRay {
  Vec3d origin, direction;
  double begin = 0, end = 0;  ///< limits of t: near and far plane, clip planes and clip box
  /// If a clip plane cuts at `begin`: its normal in the world, towards the part that is kept.
  std::optional<Vec3d> cut = {};
};

/// A position in an image, in pixels as in pointer events: `x` to the right of its upper left
/// corner, `y` below it.
struct ImagePlace {
  double x = 0, y = 0;
  int width = 0, height = 0;  ///< of the image
};

/// The ray through a position in an image. Returns nothing if everything on it is clipped.
std::optional<PickRay> pick_ray(const VolumeGrid& grid, const SceneExtent& scene,
                                const RenderSettings& settings, const Camera& camera,
                                const ImagePlace& place);

/// Whether the ray meets the box [low, high] (voxels of level 0) between `begin` and `end`.
bool meets_box(const PickRay& ray, Vec3d low, Vec3d high);

/// Whether low ≤ voxel ≤ high along each axis, up to rounding: a position on a face counts on both
/// sides.
bool is_in_box(Vec3d low, Vec3d voxel, Vec3d high);

/// Whether a position (voxels of level 0) is in the volume, up to rounding.
bool is_in_volume(const VolumeGrid& grid, Vec3d voxel);

/// An intersection of the ray with the isosurface of a cell.
struct PickHit {
  double distance = 0;  ///< t of the ray
  Vec3d voxel;          ///< position in voxels of level 0
  Vec3d gradient;       ///< of the cell's trilinear function, quantized values per voxel of level 0
  uint32_t isosurface = 0;
  uint32_t level = 0;
  bool crosses = true;  ///< false for a box of a thin structure: the ray crosses no surface
};

/// Adds the intersections with the cells of these samples, in no particular order. For coarse
/// cells, it intersects the surface that is drawn for them (thin_structure.h). The bytes of samples
/// need not be valid.
/// `quantized_isovalues`: of each isosurface; NaN for those that are not shown.
void add_hits(const PickRay& ray, const BlockKey& block, std::span<const PackedSample> samples,
              std::span<const float> quantized_isovalues, std::vector<PickHit>& hits);

/// The nearest of the hits, and its distance to the next surface behind it. Intersections in cells
/// that touch count once. Returns nothing if there are no hits.
std::optional<SurfacePick> nearest_pick(const VolumeGrid& grid, const ValueMapping& mapping,
                                        const PickRay& ray, std::vector<PickHit> hits);

}  // namespace isosplat::render
