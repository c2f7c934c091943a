#include <string>
#include <tuple>
#include <vector>

#include "shared/bindings/wasm/core_api.h"
#include "shared/bindings/wasm/core_state.h"
#include "shared/core/grid/region_mask.h"
#include "shared/core/points/chunk_samples.h"
#include "shared/core/points/field_samples.h"
#include "shared/core/sampling/sample_clusters.h"
#include "shared/core/sampling/sample_neighbours.h"

#define XXH_INLINE_ALL
#include "xxhash.h"

// The functions of core_api.h that decode chunks, and project their samples.
using namespace isosplat;
using namespace isosplat::wasm;

namespace {

static_assert(std::tuple_size_v<RegionMask::Words> == ISOSPLAT_REGION_WORDS);

/// 0x and eight digits.
std::string hexadecimal(uint32_t word) {
  std::string text = "0x";
  for (int shift = 28; shift >= 0; shift -= 4) text += "0123456789abcdef"[word >> shift & 15];
  return text;
}

ChunkShape chunk_shape(const IsosplatChunkShape& shape) {
  ChunkShape result;
  result.block_cells = as_index(shape.block_cells);
  result.band_begin = shape.band_begin;
  result.band_end = shape.band_end;
  result.cell_count = shape.cells;
  result.has_intervals = shape.level != 0;
  return result;
}

/// The position of a block of the open store.
Result<ChunkFrame> chunk_frame(const IsosplatCore* core, uint32_t level, const uint32_t* block) {
  const StoreInfo& info = core->store->info();
  if (level >= info.levels) {
    return fail(Status::not_found, "level " + std::to_string(level) + " does not exist");
  }
  return ChunkFrame{&info.grid, &info.mapping, {level, as_index(block)}};
}

/// Decodes to core->cells, and returns the position of their block.
Result<ChunkFrame> decode_cells(IsosplatCore* core, const void* data, uint32_t bytes,
                                const IsosplatChunkShape& shape) {
  const auto frame = chunk_frame(core, shape.level, shape.block);
  if (!frame) return frame;
  auto decoded = core->decoder.decode(as_bytes(data, bytes), chunk_shape(shape), core->cells);
  if (!decoded) return tl::unexpected(decoded.error());
  return frame;
}

void put_points(IsosplatCore* core, const PointArrays& points) {
  std::vector<Vec3f> positions;
  for (const Vec3d& at : points.positions) {
    positions.push_back(
        {static_cast<float>(at.x), static_cast<float>(at.y), static_cast<float>(at.z)});
  }
  put(core, ISOSPLAT_POINTS_POSITIONS, positions);
  put(core, ISOSPLAT_POINTS_NORMALS, points.normals);
}

/// Compares a checksum with that of the directory.
IsosplatStatus check(IsosplatCore* core, const void* data, uint32_t bytes, uint32_t checksum) {
  const uint32_t found = isosplat_core_checksum(data, bytes);
  if (found == checksum) return kOk;
  return report(core, Status::checksum_mismatch,
                "checksum differs (expected " + hexadecimal(checksum) + ", found " +
                    hexadecimal(found) + ")");
}

}  // namespace

extern "C" {

uint32_t isosplat_core_checksum(const void* data, uint32_t bytes) {
  return static_cast<uint32_t>(XXH3_64bits(data, bytes));
}

IsosplatStatus isosplat_core_decode_packed(IsosplatCore* core, const void* data, uint32_t bytes,
                                           const IsosplatChunkShape* shape) {
  const auto decoded =
      core->decoder.decode_packed(as_bytes(data, bytes), chunk_shape(*shape), core->packed);
  core->results[0] = std::as_bytes(std::span(core->packed));  // empty after an error
  return decoded ? kOk : report(core, decoded.error());
}

IsosplatStatus isosplat_core_decode_chunk(IsosplatCore* core, const void* data, uint32_t bytes,
                                          const IsosplatChunkShape* shape, uint32_t checksum) {
  const IsosplatStatus checked = check(core, data, bytes, checksum);
  if (checked != kOk) return checked;
  const IsosplatStatus status = isosplat_core_decode_packed(core, data, bytes, shape);
  if (status != kOk) return status;
  core->clusters = cluster_samples(core->packed, core->ordered);
  if (shape->level > 0) mark_neighbours(core->ordered);
  core->results[ISOSPLAT_DECODED_SAMPLES] = std::as_bytes(std::span(core->ordered));
  core->results[ISOSPLAT_DECODED_CLUSTERS] = std::as_bytes(std::span(core->clusters));
  return kOk;
}

IsosplatStatus isosplat_core_decode_field(IsosplatCore* core, const void* data, uint32_t bytes,
                                          const IsosplatChunkShape* shape, uint32_t checksum,
                                          const void* samples, uint32_t count,
                                          uint32_t value_bits) {
  const IsosplatStatus checked = check(core, data, bytes, checksum);
  if (checked != kOk) return checked;
  const auto decoded =
      decode_field_samples(core->decoder, as_bytes(data, bytes), as_index(shape->block_cells),
                           {static_cast<const PackedSample*>(samples), count},
                           value_bits == 8 ? 256 : 65536, core->field);
  core->results[0] = std::as_bytes(std::span(core->field));  // empty after an error
  return decoded ? kOk : report(core, decoded.error());
}

IsosplatStatus isosplat_core_decode_samples(IsosplatCore* core, const void* data, uint32_t bytes,
                                            const IsosplatChunkShape* shape) {
  if (!core->store) return no_store(core);
  const auto frame = decode_cells(core, data, bytes, *shape);
  if (!frame) return report(core, frame.error());
  const SampleArrays samples = samples_of(core->cells, *frame);
  put(core, ISOSPLAT_SAMPLES_POSITIONS, samples.positions);
  put(core, ISOSPLAT_SAMPLES_VALUES, samples.values);
  put(core, ISOSPLAT_SAMPLES_GRADIENTS, samples.gradients);
  put(core, ISOSPLAT_SAMPLES_INTERVALS, samples.intervals);
  return kOk;
}

IsosplatStatus isosplat_core_project(IsosplatCore* core, const void* data, uint32_t bytes,
                                     const IsosplatChunkShape* shape, float quantized_isovalue,
                                     uint32_t exact) {
  if (!core->store) return no_store(core);
  const auto frame = decode_cells(core, data, bytes, *shape);
  if (!frame) return report(core, frame.error());
  put_points(core, project_samples(core->cells, *frame, quantized_isovalue,
                                   {exact != 0, Displaced::clamp}));
  return kOk;
}

IsosplatStatus isosplat_core_project_packed(IsosplatCore* core, const void* samples, uint32_t count,
                                            const uint32_t* regions, const IsosplatBlock* block,
                                            float quantized_isovalue, uint32_t exact) {
  if (!core->store) return no_store(core);
  const auto frame = chunk_frame(core, block->level, block->block);
  if (!frame) return report(core, frame.error());
  const auto mask = regions ? RegionMask::from_words(regions) : RegionMask::all();
  const DecodedCells cells = cells_of({static_cast<const PackedSample*>(samples), count}, mask);
  put_points(core,
             project_samples(cells, *frame, quantized_isovalue, {exact != 0, Displaced::clamp}));
  return kOk;
}

}  // extern "C"
