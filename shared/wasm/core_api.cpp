#include "shared/wasm/core_api.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "shared/codec/chunk_codec.h"
#include "shared/points/chunk_samples.h"
#include "shared/select/selector.h"
#include "shared/store/store_reader.h"

#define XXH_INLINE_ALL
#include "xxhash.h"

using namespace isosplat;

/// An open store, or just a decoder, with the results of the last call.
struct IsosplatCore {
  std::unique_ptr<StoreReader> store;
  std::optional<Selector> selector;
  ChunkDecoder decoder;
  std::vector<PackedSample> packed;
  DecodedCells cells;
  std::string error;
  std::array<std::vector<std::byte>, 4> copies;
  std::array<std::span<const std::byte>, 4> results;  ///< in `copies`, or where they arose
};

namespace {

static_assert(sizeof(IsosplatChunk) == 56 && sizeof(IsosplatPage) == 40, "web/core reads these");

constexpr uint32_t kOk = static_cast<uint32_t>(Status::ok);

uint32_t report(IsosplatCore* core, const Error& error) {
  core->error = error.message;
  return static_cast<uint32_t>(error.status);
}

uint32_t report(IsosplatCore* core, Status status, std::string message) {
  return report(core, Error{status, std::move(message)});
}

uint32_t no_store(IsosplatCore* core) {
  return report(core, Status::invalid_argument, "no store is open: call open first");
}

std::span<const std::byte> as_bytes(const void* data, uint32_t bytes) {
  return {static_cast<const std::byte*>(data), bytes};
}

std::array<double, 3> as_numbers(const CoarseRange& range) {
  return {static_cast<double>(range.first_level), static_cast<double>(range.offset),
          static_cast<double>(range.bytes)};
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

uint32_t as_u32(int32_t value) {
  return static_cast<uint32_t>(value);
}

IsosplatChunk describe(IsosplatCore* core, const ChunkRef& chunk) {
  IsosplatChunk result{};
  result.offset = static_cast<double>(chunk.offset);
  result.handle = core->selector->handle_of(chunk);
  result.level = chunk.block.level;
  result.block[0] = as_u32(chunk.block.index.x);
  result.block[1] = as_u32(chunk.block.index.y);
  result.block[2] = as_u32(chunk.block.index.z);
  result.band = chunk.band;
  result.band_begin = chunk.band_begin;
  result.band_end = chunk.band_end;
  result.bytes = chunk.bytes;
  result.cells = chunk.cells;
  result.checksum = chunk.checksum;
  const Index3 cells =
      block_cells(core->store->levels()[chunk.block.level].grid, chunk.block.index);
  result.block_cells = as_u32(cells.x) | as_u32(cells.y) << 8 | as_u32(cells.z) << 16;
  return result;
}

ChunkShape chunk_shape(const uint32_t* shape) {
  ChunkShape result;
  result.block_cells = {static_cast<int32_t>(shape[0]), static_cast<int32_t>(shape[1]),
                        static_cast<int32_t>(shape[2])};
  result.band_begin = shape[3];
  result.band_end = shape[4];
  result.cell_count = shape[5];
  result.has_intervals = shape[6] != 0;
  return result;
}

/// Where a block of the open store is.
Result<ChunkFrame> chunk_frame(const IsosplatCore* core, uint32_t level, const uint32_t* block) {
  const StoreInfo& info = core->store->info();
  if (level >= info.levels) {
    return fail(Status::not_found, "level " + std::to_string(level) + " does not exist");
  }
  const Index3 index{static_cast<int32_t>(block[0]), static_cast<int32_t>(block[1]),
                     static_cast<int32_t>(block[2])};
  return ChunkFrame{&info.grid, &info.mapping, {level, index}};
}

/// Decodes to core->cells, and says where they are.
Result<ChunkFrame> decode_cells(IsosplatCore* core, const void* data, uint32_t bytes,
                                const uint32_t* shape, const uint32_t* block) {
  const auto frame = chunk_frame(core, shape[6], block);
  if (!frame) return frame;
  auto decoded = core->decoder.decode(as_bytes(data, bytes), chunk_shape(shape), core->cells);
  if (!decoded) return tl::unexpected(decoded.error());
  return frame;
}

/// Result 0: positions, 1: normals.
void put_points(IsosplatCore* core, const PointArrays& points) {
  std::vector<Vec3f> positions;
  for (const Vec3d& at : points.positions) {
    positions.push_back(
        {static_cast<float>(at.x), static_cast<float>(at.y), static_cast<float>(at.z)});
  }
  put(core, 0, positions);
  put(core, 1, points.normals);
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

const char* isosplat_core_status_name(uint32_t status) {
  // The names are literals, which end in a null.
  return status_name(static_cast<Status>(status)).data();
}

const void* isosplat_core_result(const IsosplatCore* core, uint32_t buffer) {
  return buffer < core->results.size() ? core->results[buffer].data() : nullptr;
}

uint32_t isosplat_core_result_bytes(const IsosplatCore* core, uint32_t buffer) {
  return buffer < core->results.size() ? static_cast<uint32_t>(core->results[buffer].size()) : 0;
}

uint32_t isosplat_core_open(IsosplatCore* core, const void* header, uint32_t bytes) {
  core->selector.reset();
  core->store.reset();
  auto store = StoreReader::open(as_bytes(header, bytes));
  if (!store) return report(core, store.error());
  core->store = std::make_unique<StoreReader>(std::move(*store));
  core->selector.emplace(*core->store);
  return kOk;
}

uint32_t isosplat_core_info(IsosplatCore* core) {
  if (!core->store) return no_store(core);
  const StoreInfo& info = core->store->info();
  std::vector<double> numbers;
  for (const int32_t n : {info.grid.voxels.x, info.grid.voxels.y, info.grid.voxels.z}) {
    numbers.push_back(n);
  }
  for (const Vec3d& v : {info.grid.spacing, info.grid.origin}) {
    numbers.insert(numbers.end(), {v.x, v.y, v.z});
  }
  numbers.insert(numbers.end(), info.grid.direction.begin(), info.grid.direction.end());
  const ValueMapping& mapping = info.mapping;
  numbers.insert(numbers.end(),
                 {mapping.offset, mapping.scale, mapping.max_error,
                  static_cast<double>(mapping.bits), mapping.has_missing ? 1.0 : 0.0,
                  static_cast<double>(info.range.min), static_cast<double>(info.range.max),
                  static_cast<double>(info.levels), static_cast<double>(info.chunk_count),
                  static_cast<double>(info.missing_voxels), static_cast<double>(info.file_bytes)});
  put(core, 0, numbers);
  put(core, 1, info.content_id);
  put(core, 2, info.metadata);
  return kOk;
}

float isosplat_core_quantized_isovalue(const IsosplatCore* core, double isovalue) {
  return core->store ? core->store->info().mapping.quantized_isovalue(isovalue)
                     : std::numeric_limits<float>::quiet_NaN();
}

uint32_t isosplat_core_coarse_range(IsosplatCore* core, double max_bytes) {
  if (!core->store) return no_store(core);
  const double limit = std::clamp(max_bytes, 0.0, 9e15);
  put(core, 0, as_numbers(core->store->coarse_range(static_cast<uint64_t>(limit))));
  return kOk;
}

uint32_t isosplat_core_bootstrap_range(IsosplatCore* core) {
  if (!core->store) return no_store(core);
  put(core, 0, as_numbers(core->store->bootstrap_range()));
  return kOk;
}

uint32_t isosplat_core_pages(IsosplatCore* core) {
  if (!core->store) return no_store(core);
  std::vector<IsosplatPage> pages;
  uint32_t index = 0;
  for (const PageRef& page : core->store->pages()) {
    pages.push_back(
        {static_cast<double>(page.offset),
         page.bytes,
         page.level,
         {as_u32(page.first_block.x), as_u32(page.first_block.y), as_u32(page.first_block.z)},
         core->store->is_resident(index++) ? 1u : 0u,
         page.interval.min,
         page.interval.max});
  }
  put(core, 0, pages);
  return kOk;
}

uint32_t isosplat_core_add_page(IsosplatCore* core, uint32_t page, const void* data,
                                uint32_t bytes) {
  if (!core->store) return no_store(core);
  const auto added = core->store->add_page(page, as_bytes(data, bytes));
  return added ? kOk : report(core, added.error());
}

uint32_t isosplat_core_missing_pages(IsosplatCore* core, uint32_t level, float low, float high) {
  if (!core->store) return no_store(core);
  put(core, 0, core->store->missing_pages(level, low, high));
  return kOk;
}

uint32_t isosplat_core_chunks_for(IsosplatCore* core, uint32_t level, float low, float high) {
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

uint32_t isosplat_core_decode_packed(IsosplatCore* core, const void* data, uint32_t bytes,
                                     const uint32_t* shape) {
  const auto decoded =
      core->decoder.decode_packed(as_bytes(data, bytes), chunk_shape(shape), core->packed);
  core->results[0] = std::as_bytes(std::span(core->packed));  // empty after an error
  return decoded ? kOk : report(core, decoded.error());
}

uint32_t isosplat_core_decode_samples(IsosplatCore* core, const void* data, uint32_t bytes,
                                      const uint32_t* shape, const uint32_t* block) {
  if (!core->store) return no_store(core);
  const auto frame = decode_cells(core, data, bytes, shape, block);
  if (!frame) return report(core, frame.error());
  const SampleArrays samples = samples_of(core->cells, *frame);
  put(core, 0, samples.positions);
  put(core, 1, samples.values);
  put(core, 2, samples.gradients);
  put(core, 3, samples.intervals);
  return kOk;
}

uint32_t isosplat_core_project(IsosplatCore* core, const void* data, uint32_t bytes,
                               const uint32_t* shape, const uint32_t* block,
                               float quantized_isovalue, uint32_t exact) {
  if (!core->store) return no_store(core);
  const auto frame = decode_cells(core, data, bytes, shape, block);
  if (!frame) return report(core, frame.error());
  put_points(core, project_samples(core->cells, *frame, quantized_isovalue,
                                   {exact != 0, Displaced::clamp}));
  return kOk;
}

uint32_t isosplat_core_project_packed(IsosplatCore* core, const void* samples, uint32_t count,
                                      const uint32_t* regions, uint32_t level,
                                      const uint32_t* block, float quantized_isovalue,
                                      uint32_t exact) {
  if (!core->store) return no_store(core);
  const auto frame = chunk_frame(core, level, block);
  if (!frame) return report(core, frame.error());
  const auto mask = regions ? RegionMask::from_words(regions) : RegionMask::all();
  const DecodedCells cells = cells_of({static_cast<const PackedSample*>(samples), count}, mask);
  put_points(core,
             project_samples(cells, *frame, quantized_isovalue, {exact != 0, Displaced::clamp}));
  return kOk;
}

uint32_t isosplat_core_select(IsosplatCore* core, const double* view,
                              const float* quantized_isovalues, uint32_t isovalue_count) {
  if (!core->store) return no_store(core);
  SelectionView asked;
  std::copy_n(view, 16, asked.view_projection.begin());
  asked.width_px = view[16];
  asked.height_px = view[17];
  asked.load_cell_px = view[18];
  asked.draw_cell_px = view[19];
  asked.cell_budget = static_cast<uint64_t>(std::clamp(view[20], 0.0, 9e15));
  asked.occlusion = view[22] != 0;
  asked.quantized_isovalues.assign(quantized_isovalues, quantized_isovalues + isovalue_count);
  const auto selection =
      view[21] != 0 ? core->selector->select_ahead(asked) : core->selector->select(asked);
  if (!selection) return report(core, selection.error());

  std::vector<IsosplatChunk> load;
  for (const ChunkHandle handle : selection->load) {
    load.push_back(describe(core, *core->selector->chunk(handle)));
  }
  put(core, 0, load);
  put(core, 1, selection->pages);
  std::vector<uint32_t> draw;
  for (const DrawnChunk& drawn : selection->draw) {
    draw.push_back(drawn.handle);
    const auto regions = drawn.regions.words();
    draw.insert(draw.end(), regions.begin(), regions.end());
  }
  put(core, 2, draw);
  std::vector<uint32_t> keep{as_u32(selection->finest_drawn_level),
                             as_u32(selection->coarsest_drawn_level),
                             selection->limited_by_budget ? 1u : 0u, selection->undecided,
                             static_cast<uint32_t>(selection->test.size())};
  keep.insert(keep.end(), selection->test.begin(), selection->test.end());
  keep.insert(keep.end(), selection->keep.begin(), selection->keep.end());
  put(core, 3, keep);
  return kOk;
}

uint32_t isosplat_core_set_visibility(IsosplatCore* core, const uint32_t* answer, uint32_t count) {
  if (!core->store) return no_store(core);
  constexpr size_t kMaskWords = std::tuple_size_v<RegionMask::Words>;
  std::vector<ChunkVisibility> drawn;
  for (uint32_t i = 0; i < count; ++i, answer += 1 + 2 * kMaskWords) {
    drawn.push_back({answer[0], RegionMask::from_words(answer + 1),
                     RegionMask::from_words(answer + 1 + kMaskWords)});
  }
  const auto set = core->selector->set_visibility(drawn);
  return set ? kOk : report(core, set.error());
}

uint32_t isosplat_core_set_resident(IsosplatCore* core, uint32_t handle, uint32_t resident) {
  if (!core->store) return no_store(core);
  const auto set = core->selector->set_resident(handle, resident != 0);
  return set ? kOk : report(core, set.error());
}

}  // extern "C"
