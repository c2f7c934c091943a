#include "shared/render/pick/field_pick.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

namespace isosplat::render {
namespace {

/// How far outside of its cell a position still counts as inside, in cells: picks lie on the faces
/// of cells, up to rounding.
constexpr double kTolerance = 1e-4;

bool is_in_box(Vec3d at, Vec3d low, Vec3d high) {
  const auto is_between = [](double p, double from, double to) {
    return p >= from - kTolerance && p <= to + kTolerance;
  };
  return is_between(at.x, low.x, high.x) && is_between(at.y, low.y, high.y) &&
         is_between(at.z, low.z, high.z);
}

/// The quantized value at `at` (0 to 1 in the cell). NaN if a corner is missing; of categories, if
/// the nearest is.
double value_in(const PackedField& field, bool has_missing, bool is_category, Vec3d at) {
  const auto nearest = [](double part) { return part < 0.5 ? 0.0 : 1.0; };
  if (is_category) at = {nearest(at.x), nearest(at.y), nearest(at.z)};
  double sum = 0;
  for (uint32_t corner = 0; corner < 8; ++corner) {
    const uint32_t value = field.word[corner >> 1] >> (16 * (corner & 1)) & 0xffff;
    const double weight = (corner & 1 ? at.x : 1 - at.x) * (corner & 2 ? at.y : 1 - at.y) *
                          (corner & 4 ? at.z : 1 - at.z);
    if (is_category && weight == 0) continue;
    if (has_missing && value == kMissingVoxel) return std::numeric_limits<double>::quiet_NaN();
    sum += value * weight;
  }
  return sum;
}

/// The value in one of a chunk's cells at `at`, in cells of its block; nothing if it has no cell
/// there.
std::optional<double> value_at(const ChunkStore& chunks, const ChunkStore::Chunk& chunk,
                               bool has_missing, bool is_category, Vec3d at) {
  const auto vector = [](auto v) { return Vec3d{double(v.x), double(v.y), double(v.z)}; };
  std::vector<PackedSample> samples;
  for (const SampleCluster& cluster : chunk.clusters) {
    if (!is_in_box(at, vector(cluster.low), vector(cluster.high))) continue;
    samples.resize(cluster.count);
    chunks.buffers().read(chunk.range, cluster.first, samples);
    for (uint32_t i = 0; i < cluster.count; ++i) {
      const Vec3d low = vector(unpack_sample(samples[i]).cell);
      if (!is_in_box(at, low, low + Vec3d{1, 1, 1})) continue;
      PackedField field;
      chunks.buffers().read_field(chunk.range, cluster.first + i, {&field, 1});
      return value_in(field, has_missing, is_category, at - low);
    }
  }
  return std::nullopt;
}

}  // namespace

void pick_field(const ChunkStore& chunks, const ValueMapping& field, bool is_category,
                SurfacePick& pick) {
  if (pick.cap || pick.slice) return;
  const Vec3d at = pick.voxel * std::ldexp(1.0, -static_cast<int>(pick.level));
  for (const DrawnChunk& visible : chunks.visible()) {
    const ChunkStore::Chunk* chunk = chunks.find(visible.handle);
    if (!chunk || !chunk->has_field || chunk->block.level != pick.level) continue;
    const Index3 block = chunk->block.index;
    const Vec3d corner = Vec3d{double(block.x), double(block.y), double(block.z)} * kBlockCells;
    const auto found = value_at(chunks, *chunk, field.has_missing, is_category, at - corner);
    if (!found) continue;
    pick.field = field.value(*found);
    return;
  }
}

}  // namespace isosplat::render
