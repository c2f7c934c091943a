#include "shared/bindings/library/convert.h"

#include <cmath>

namespace isosplat {

Volume volume_of(const StoreInfo& info) {
  Volume volume;
  volume.voxels = info.grid.voxels;
  volume.spacing = info.grid.spacing;
  volume.origin = info.grid.origin;
  volume.direction = info.grid.direction;
  volume.value_offset = info.mapping.offset;
  volume.value_scale = info.mapping.scale;
  volume.max_error = info.mapping.max_error;
  volume.min_value = info.mapping.value(info.range.min);
  volume.max_value = info.mapping.value(info.range.max);
  volume.missing_voxels = info.missing_voxels;
  volume.levels = info.levels;
  return volume;
}

VolumeGrid grid_of(const Volume& volume) {
  return {volume.voxels, volume.spacing, volume.origin, volume.direction};
}

ValueMapping mapping_of(const Volume& volume) {
  ValueMapping mapping;
  mapping.offset = volume.value_offset;
  mapping.scale = volume.value_scale;
  mapping.max_error = volume.max_error;
  mapping.has_missing = volume.missing_voxels > 0;
  return mapping;
}

Chunk chunk_of(const ChunkRef& ref) {
  return {ref.block.level, ref.block.index, ref.band,  ref.band_begin, ref.band_end,
          ref.offset,      ref.bytes,       ref.cells, ref.checksum};
}

ChunkRef chunk_ref_of(const Chunk& chunk) {
  return {{chunk.level, chunk.block},
          chunk.band,
          static_cast<QuantizedValue>(chunk.band_begin),
          chunk.band_end,
          chunk.offset,
          chunk.bytes,
          chunk.cells,
          chunk.checksum};
}

std::vector<Chunk> chunks_of(const std::vector<ChunkRef>& refs) {
  std::vector<Chunk> chunks;
  for (const ChunkRef& ref : refs) {
    if (ref.cells > 0) chunks.push_back(chunk_of(ref));
  }
  return chunks;
}

Result<void> check_query(const Volume& volume, uint32_t level, double isovalue) {
  if (level >= volume.levels) {
    return fail(Status::not_found, "expected a level below " + std::to_string(volume.levels) +
                                       ", found " + std::to_string(level));
  }
  if (!std::isfinite(isovalue)) {
    return fail(Status::invalid_argument,
                "expected a finite isovalue, found " + std::to_string(isovalue));
  }
  return {};
}

}  // namespace isosplat
