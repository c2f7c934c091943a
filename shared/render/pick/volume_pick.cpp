#include "shared/render/pick/volume_pick.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "shared/render/pick/cap_pick.h"

namespace isosplat::render {
namespace {

/// The quantized isovalue of each isosurface of the settings; NaN for those of other volumes, and
/// for those that are not shown.
std::vector<float> quantized_isovalues_of(const RenderSettings& settings,
                                          const ValueMapping& mapping, VolumeId volume) {
  std::vector<float> quantized;
  int own = 0;
  for (const Isosurface& surface : settings.isosurfaces) {
    const bool is_own = surface.volume == volume && own++ < kMaxIsosurfaces;
    quantized.push_back(is_own && surface.opacity > 0 ? mapping.quantized_isovalue(surface.isovalue)
                                                      : std::numeric_limits<float>::quiet_NaN());
  }
  return quantized;
}

/// All intersections of the ray with the visible chunks.
std::vector<PickHit> hits_of(const ChunkStore& chunks, const PickRay& ray,
                             std::span<const float> quantized_isovalues) {
  const auto is_any_active = [&](CellInterval interval) {
    return std::any_of(quantized_isovalues.begin(), quantized_isovalues.end(),
                       [interval](float q) { return is_active(interval, q); });
  };
  std::vector<PickHit> hits;
  std::vector<PackedSample> samples;
  for (const DrawnChunk& visible : chunks.visible()) {
    const ChunkStore::Chunk* chunk = chunks.find(visible.handle);
    if (!chunk || !is_any_active(chunk->interval)) continue;
    if (!meets_box(ray, chunk->low, chunk->high)) continue;
    const double size = std::ldexp(1.0, static_cast<int>(chunk->block.level));
    const Index3 block = chunk->block.index;
    const Vec3d corner =
        Vec3d{double(block.x), double(block.y), double(block.z)} * (kBlockCells * size);
    for (const SampleCluster& cluster : chunk->clusters) {
      if (!visible.regions.contains(cluster.region_index())) continue;
      if (!is_any_active(cluster.interval)) continue;
      const auto position = [&](Vec3<uint8_t> cell) {
        return corner + Vec3d{double(cell.x), double(cell.y), double(cell.z)} * size;
      };
      if (!meets_box(ray, position(cluster.low), position(cluster.high))) continue;
      samples.resize(cluster.count);
      chunks.buffers().read(chunk->range, cluster.first, samples);
      add_hits(ray, chunk->block, samples, quantized_isovalues, hits);
    }
  }
  return hits;
}

}  // namespace

std::optional<VolumePick> pick_volume(const VolumeGrid& grid, const ValueMapping& mapping,
                                      const ChunkStore& chunks, VolumeId volume,
                                      const RenderSettings& settings, const SceneExtent& scene,
                                      const Camera& camera, const ImagePlace& place) {
  const auto ray = pick_ray(grid, scene, settings, camera, place);
  if (!ray) return std::nullopt;
  std::vector<PickHit> hits =
      hits_of(chunks, *ray, quantized_isovalues_of(settings, mapping, volume));
  double distance = ray->begin;
  std::optional<SurfacePick> pick = pick_cap(grid, settings, *ray, hits);
  if (!pick) {
    distance = ray->end;
    for (const PickHit& hit : hits) distance = std::min(distance, hit.distance);
    pick = nearest_pick(grid, mapping, *ray, std::move(hits));
  }
  if (!pick) return std::nullopt;
  pick->value = settings.isosurfaces[pick->isosurface].isovalue;
  return VolumePick{*pick, distance};
}

}  // namespace isosplat::render
