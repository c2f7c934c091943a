#include "shared/render/pick/slice_pick.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "shared/core/base/matrix3.h"
#include "shared/core/sampling/trilinear.h"
#include "shared/render/frame/frame.h"
#include "shared/render/shaders/shader_constants.h"

namespace isosplat::render {
namespace {

/// The quantized value of the chunk's cell at a place, in voxels of level 0.
std::optional<float> value_in_chunk(const ChunkStore::Chunk& chunk, const SampleBuffers& buffers,
                                    Vec3d voxel) {
  if (!is_in_box(chunk.low, voxel, chunk.high)) return std::nullopt;
  const double size = std::ldexp(1.0, static_cast<int>(chunk.block.level));
  const Vec3d in_block = (voxel - chunk.low) * (1 / size);
  std::vector<PackedSample> samples;
  for (const SampleCluster& cluster : chunk.clusters) {
    const auto as_place = [](Vec3<uint8_t> p) {
      return Vec3d{double(p.x), double(p.y), double(p.z)};
    };
    if (!is_in_box(as_place(cluster.low), in_block, as_place(cluster.high))) continue;
    samples.resize(cluster.count);
    buffers.read(chunk.range, cluster.first, samples);
    for (const PackedSample& packed : samples) {
      const UnpackedSample sample = unpack_sample(packed);
      const Vec3d low{double(sample.cell.x), double(sample.cell.y), double(sample.cell.z)};
      if (!is_in_box(low, in_block, low + Vec3d{1, 1, 1})) continue;
      const Vec3d p = in_block - low;
      const auto inside = [](double at) { return static_cast<float>(std::clamp(at, 0.0, 1.0)); };
      return Trilinear(sample.corners).at({inside(p.x), inside(p.y), inside(p.z)}).value;
    }
  }
  return std::nullopt;
}

struct FoundValue {
  float quantized;
  uint32_t level;
};

std::optional<FoundValue> finest_value(const ChunkStore& chunks, Vec3d voxel) {
  std::optional<FoundValue> finest;
  for (const auto& [handle, chunk] : chunks.all()) {
    if (finest && finest->level <= chunk.block.level) continue;
    if (const auto value = value_in_chunk(chunk, chunks.buffers(), voxel)) {
      finest = FoundValue{*value, chunk.block.level};
    }
  }
  return finest;
}

}  // namespace

std::optional<SurfacePick> pick_slice(const VolumeGrid& grid, const ValueMapping& mapping,
                                      const RenderSettings& settings, const ChunkStore& chunks,
                                      const PickRay& ray, double before) {
  const Vec3d origin = grid.world(ray.origin);
  const Vec3d direction = grid.world(ray.origin + ray.direction) - origin;
  std::optional<SurfacePick> pick;
  for (size_t i = 0; i < settings.slices.size() && i < kMaxSlices; ++i) {
    const auto slice = unit_plane(settings.slices[i]);
    if (!slice) continue;
    const auto& [normal, offset] = *slice;
    const double per_step = dot(normal, direction), t = (offset - dot(normal, origin)) / per_step;
    // As in the picture, a slice that lies in a face of the clipping is not clipped, and is in
    // front of the cap of this face.
    const double margin = SLICE_MARGIN * unit_of_frame_space(grid) / std::abs(per_step);
    if (!(t >= ray.begin - margin && t <= before + margin)) continue;
    const Vec3d voxel = ray.origin + ray.direction * t;
    if (!is_in_volume(grid, voxel)) continue;
    const auto found = finest_value(chunks, voxel);
    if (!found) continue;
    before = t;
    pick.emplace();
    pick->voxel = voxel;
    pick->position = grid.world(voxel);
    pick->normal = normal * (per_step > 0 ? -1.0 : 1.0);
    pick->level = found->level;
    pick->slice = true;
    pick->value = mapping.value(double(found->quantized));
  }
  return pick;
}

}  // namespace isosplat::render
