#include "shared/render/pick/cap_pick.h"

#include <algorithm>

namespace isosplat::render {
namespace {

/// The shown isosurface of the volume with the highest isovalue that is reached before this hit.
std::optional<uint32_t> reached_isosurface(const RenderSettings& settings, const PickHit& hit,
                                           bool falls) {
  const auto& isosurfaces = settings.isosurfaces;
  const double crossed = isosurfaces[hit.isosurface].isovalue;
  std::optional<uint32_t> highest;
  const VolumeId volume = isosurfaces[hit.isosurface].volume;
  for (uint32_t i = 0; i < isosurfaces.size(); ++i) {
    if (isosurfaces[i].volume != volume) continue;
    const double isovalue = isosurfaces[i].isovalue;
    const bool is_reached = falls ? isovalue <= crossed : isovalue < crossed;
    if (!is_reached || isosurfaces[i].opacity <= 0) continue;
    if (!highest || isovalue > isosurfaces[*highest].isovalue) highest = i;
  }
  return highest;
}

}  // namespace

std::optional<SurfacePick> pick_cap(const VolumeGrid& grid, const RenderSettings& settings,
                                    const PickRay& ray, std::span<const PickHit> hits) {
  if (!settings.clip_caps || !settings.projected || !ray.cut || hits.empty()) return std::nullopt;
  const PickHit& hit =
      *std::min_element(hits.begin(), hits.end(),
                        [](const PickHit& a, const PickHit& b) { return a.distance < b.distance; });
  const Vec3d voxel = ray.origin + ray.direction * ray.begin;
  if (!hit.crosses || !is_in_volume(grid, voxel)) return std::nullopt;
  const bool falls = dot(hit.gradient, ray.direction) <= 0;
  const auto isosurface = reached_isosurface(settings, hit, falls);
  if (!isosurface) return std::nullopt;
  SurfacePick pick;
  pick.voxel = voxel;
  pick.position = grid.world(voxel);
  pick.normal = *ray.cut * (-1 / length(*ray.cut));
  pick.to_next = (hit.distance - ray.begin) *
                 length(grid.world(ray.origin + ray.direction) - grid.world(ray.origin));
  pick.isosurface = *isosurface;
  pick.level = hit.level;
  pick.cap = true;
  return pick;
}

}  // namespace isosplat::render
