#include "shared/bindings/wasm/core_api.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "shared/core/codec/chunk_codec.h"
#include "shared/core/points/chunk_samples.h"
#include "shared/core/sampling/sample_clusters.h"
#include "shared/core/sampling/sample_neighbours.h"
#include "shared/core/select/selector.h"
#include "shared/core/store/store_reader.h"

#define XXH_INLINE_ALL
#include "xxhash.h"

using namespace isosplat;

/// An open store, or just a decoder, with the results of the last call.
struct IsosplatCore {
  std::unique_ptr<StoreReader> store;
  std::optional<Selector> selector;
  ChunkDecoder decoder;
  std::vector<PackedSample> packed, ordered;
  std::vector<SampleCluster> clusters;
  DecodedCells cells;
  std::string error;
  std::array<std::vector<std::byte>, ISOSPLAT_RESULT_BUFFERS> copies;
  /// Each is in `copies` or in another member.
  std::array<std::span<const std::byte>, ISOSPLAT_RESULT_BUFFERS> results;
};

namespace {

static_assert(std::tuple_size_v<RegionMask::Words> == ISOSPLAT_REGION_WORDS);

constexpr IsosplatStatus kOk = static_cast<IsosplatStatus>(Status::ok);

IsosplatStatus report(IsosplatCore* core, const Error& error) {
  core->error = error.message;
  return static_cast<IsosplatStatus>(error.status);
}

IsosplatStatus report(IsosplatCore* core, Status status, std::string message) {
  return report(core, Error{status, std::move(message)});
}

IsosplatStatus no_store(IsosplatCore* core) {
  return report(core, Status::invalid_argument, "no store is open: call open first");
}

std::span<const std::byte> as_bytes(const void* data, uint32_t bytes) {
  return {static_cast<const std::byte*>(data), bytes};
}

template <class T>
void put(IsosplatCore* core, size_t buffer, const T* items, size_t count) {
  const auto bytes = std::as_bytes(std::span(items, count));
  core->copies[buffer].assign(bytes.begin(), bytes.end());
  core->results[buffer] = core->copies[buffer];
}

template <class Container>
void put(IsosplatCore* core, size_t buffer, const Container& items) {
  put(core, buffer, items.data(), items.size());
}

template <class Record>
void put_record(IsosplatCore* core, size_t buffer, const Record& record) {
  put(core, buffer, &record, 1);
}

void put_range(IsosplatCore* core, const CoarseRange& range) {
  put_record(
      core, 0,
      IsosplatCoarseRange{static_cast<double>(range.first_level), static_cast<double>(range.offset),
                          static_cast<double>(range.bytes)});
}

/// 0x and eight digits.
std::string hexadecimal(uint32_t word) {
  std::string text = "0x";
  for (int shift = 28; shift >= 0; shift -= 4) text += "0123456789abcdef"[word >> shift & 15];
  return text;
}

uint32_t as_u32(int32_t value) {
  return static_cast<uint32_t>(value);
}

Index3 as_index(const uint32_t* words) {
  return {static_cast<int32_t>(words[0]), static_cast<int32_t>(words[1]),
          static_cast<int32_t>(words[2])};
}

void copy_index(const Index3& index, uint32_t* words) {
  words[0] = as_u32(index.x);
  words[1] = as_u32(index.y);
  words[2] = as_u32(index.z);
}

void copy_vector(const Vec3d& vector, double* numbers) {
  numbers[0] = vector.x;
  numbers[1] = vector.y;
  numbers[2] = vector.z;
}

IsosplatChunk describe(IsosplatCore* core, const ChunkRef& chunk) {
  IsosplatChunk result{};
  result.offset = static_cast<double>(chunk.offset);
  result.handle = core->selector->handle_of(chunk);
  result.level = chunk.block.level;
  copy_index(chunk.block.index, result.block);
  result.band = chunk.band;
  result.band_begin = chunk.band_begin;
  result.band_end = chunk.band_end;
  result.bytes = chunk.bytes;
  result.cells = chunk.cells;
  result.checksum = chunk.checksum;
  copy_index(block_cells(core->store->levels()[chunk.block.level].grid, chunk.block.index),
             result.block_cells);
  return result;
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

}  // namespace

extern "C" {

IsosplatCore* isosplat_core_create(void) {
  return new IsosplatCore;
}

void isosplat_core_destroy(IsosplatCore* core) {
  delete core;
}

const char* isosplat_core_error(const IsosplatCore* core) {
  return core->error.c_str();
}

const char* isosplat_core_status_name(IsosplatStatus status) {
  // The names are literals, which end in a null.
  return status_name(static_cast<Status>(status)).data();
}

const void* isosplat_core_result(const IsosplatCore* core, uint32_t buffer) {
  return buffer < core->results.size() ? core->results[buffer].data() : nullptr;
}

uint32_t isosplat_core_result_bytes(const IsosplatCore* core, uint32_t buffer) {
  return buffer < core->results.size() ? static_cast<uint32_t>(core->results[buffer].size()) : 0;
}

IsosplatStatus isosplat_core_open(IsosplatCore* core, const void* header, uint32_t bytes) {
  core->selector.reset();
  core->store.reset();
  auto store = StoreReader::open(as_bytes(header, bytes));
  if (!store) return report(core, store.error());
  core->store = std::make_unique<StoreReader>(std::move(*store));
  core->selector.emplace(*core->store);
  return kOk;
}

IsosplatStatus isosplat_core_info(IsosplatCore* core) {
  if (!core->store) return no_store(core);
  const StoreInfo& info = core->store->info();
  const ValueMapping& mapping = info.mapping;
  IsosplatStoreInfo record{};
  copy_vector(info.grid.spacing, record.spacing);
  copy_vector(info.grid.origin, record.origin);
  std::copy(info.grid.direction.begin(), info.grid.direction.end(), record.direction);
  record.value_offset = mapping.offset;
  record.value_scale = mapping.scale;
  record.max_error = mapping.max_error;
  record.chunk_count = static_cast<double>(info.chunk_count);
  record.missing_voxels = static_cast<double>(info.missing_voxels);
  record.file_bytes = static_cast<double>(info.file_bytes);
  copy_index(info.grid.voxels, record.voxels);
  record.bits = mapping.bits;
  record.has_missing = mapping.has_missing;
  record.min_quantized = info.range.min;
  record.max_quantized = info.range.max;
  record.levels = info.levels;
  static_assert(sizeof info.content_id == sizeof record.content_id);
  std::memcpy(record.content_id, info.content_id.data(), sizeof record.content_id);
  put_record(core, ISOSPLAT_INFO_RECORD, record);
  put(core, ISOSPLAT_INFO_METADATA, info.metadata);
  return kOk;
}

IsosplatStatus isosplat_core_quantized_isovalue(IsosplatCore* core, double isovalue) {
  if (!core->store) return no_store(core);
  put_record(core, 0, core->store->info().mapping.quantized_isovalue(isovalue));
  return kOk;
}

IsosplatStatus isosplat_core_coarse_range(IsosplatCore* core, double max_bytes) {
  if (!core->store) return no_store(core);
  const double limit = std::clamp(max_bytes, 0.0, 9e15);
  put_range(core, core->store->coarse_range(static_cast<uint64_t>(limit)));
  return kOk;
}

IsosplatStatus isosplat_core_bootstrap_range(IsosplatCore* core) {
  if (!core->store) return no_store(core);
  put_range(core, core->store->bootstrap_range());
  return kOk;
}

IsosplatStatus isosplat_core_pages(IsosplatCore* core) {
  if (!core->store) return no_store(core);
  std::vector<IsosplatPage> pages;
  uint32_t index = 0;
  for (const PageRef& page : core->store->pages()) {
    IsosplatPage record{};
    record.offset = static_cast<double>(page.offset);
    record.bytes = page.bytes;
    record.level = page.level;
    copy_index(page.first_block, record.first_block);
    record.resident = core->store->is_resident(index++);
    record.interval_min = page.interval.min;
    record.interval_max = page.interval.max;
    pages.push_back(record);
  }
  put(core, 0, pages);
  return kOk;
}

IsosplatStatus isosplat_core_add_page(IsosplatCore* core, uint32_t page, const void* data,
                                      uint32_t bytes) {
  if (!core->store) return no_store(core);
  const auto added = core->store->add_page(page, as_bytes(data, bytes));
  return added ? kOk : report(core, added.error());
}

IsosplatStatus isosplat_core_missing_pages(IsosplatCore* core, uint32_t level, float low,
                                           float high) {
  if (!core->store) return no_store(core);
  put(core, 0, core->store->missing_pages(level, low, high));
  return kOk;
}

IsosplatStatus isosplat_core_chunks_for(IsosplatCore* core, uint32_t level, float low, float high) {
  if (!core->store) return no_store(core);
  const auto chunks = core->store->chunks_for(level, low, high);
  if (!chunks) return report(core, chunks.error());
  std::vector<IsosplatChunk> records;
  for (const ChunkRef& chunk : *chunks) records.push_back(describe(core, chunk));
  put(core, 0, records);
  return kOk;
}

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
  const uint32_t found = isosplat_core_checksum(data, bytes);
  if (found != checksum) {
    return report(core, Status::checksum_mismatch,
                  "checksum differs (expected " + hexadecimal(checksum) + ", found " +
                      hexadecimal(found) + ")");
  }
  const IsosplatStatus status = isosplat_core_decode_packed(core, data, bytes, shape);
  if (status != kOk) return status;
  core->clusters = cluster_samples(core->packed, core->ordered);
  if (shape->level > 0) mark_neighbours(core->ordered);
  core->results[ISOSPLAT_DECODED_SAMPLES] = std::as_bytes(std::span(core->ordered));
  core->results[ISOSPLAT_DECODED_CLUSTERS] = std::as_bytes(std::span(core->clusters));
  return kOk;
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

IsosplatStatus isosplat_core_select(IsosplatCore* core, const IsosplatSelectionView* view,
                                    const float* quantized_isovalues, uint32_t isovalue_count) {
  if (!core->store) return no_store(core);
  SelectionView requested;
  std::copy(std::begin(view->view_projection), std::end(view->view_projection),
            requested.view_projection.begin());
  requested.width_px = view->width_px;
  requested.height_px = view->height_px;
  requested.load_cell_px = view->load_cell_px;
  requested.draw_cell_px = view->draw_cell_px;
  requested.cell_budget = static_cast<uint64_t>(std::clamp(view->cell_budget, 0.0, 9e15));
  requested.occlusion = view->occlusion != 0;
  requested.quantized_isovalues.assign(quantized_isovalues, quantized_isovalues + isovalue_count);
  const auto selection =
      view->ahead ? core->selector->select_ahead(requested) : core->selector->select(requested);
  if (!selection) return report(core, selection.error());

  put_record(core, ISOSPLAT_SELECTION_HEADER,
             IsosplatSelectionHeader{selection->finest_drawn_level, selection->coarsest_drawn_level,
                                     selection->limited_by_budget, selection->undecided});
  std::vector<IsosplatChunk> load;
  for (const ChunkHandle handle : selection->load) {
    load.push_back(describe(core, *core->selector->chunk(handle)));
  }
  put(core, ISOSPLAT_SELECTION_LOAD, load);
  put(core, ISOSPLAT_SELECTION_PAGES, selection->pages);
  std::vector<IsosplatDrawnChunk> draw;
  for (const DrawnChunk& drawn : selection->draw) {
    IsosplatDrawnChunk& record = draw.emplace_back();
    record.handle = drawn.handle;
    const RegionMask::Words regions = drawn.regions.words();
    std::copy(regions.begin(), regions.end(), record.regions);
  }
  put(core, ISOSPLAT_SELECTION_DRAW, draw);
  put(core, ISOSPLAT_SELECTION_TEST, selection->test);
  put(core, ISOSPLAT_SELECTION_KEEP, selection->keep);
  return kOk;
}

IsosplatStatus isosplat_core_set_visibility(IsosplatCore* core, const IsosplatVisibility* answer,
                                            uint32_t count) {
  if (!core->store) return no_store(core);
  std::vector<ChunkVisibility> drawn;
  for (const IsosplatVisibility& chunk : std::span(answer, count)) {
    drawn.push_back({chunk.handle, RegionMask::from_words(chunk.tested),
                     RegionMask::from_words(chunk.visible)});
  }
  const auto set = core->selector->set_visibility(drawn);
  return set ? kOk : report(core, set.error());
}

IsosplatStatus isosplat_core_set_resident(IsosplatCore* core, uint32_t handle, uint32_t resident) {
  if (!core->store) return no_store(core);
  const auto set = core->selector->set_resident(handle, resident != 0);
  return set ? kOk : report(core, set.error());
}

}  // extern "C"
