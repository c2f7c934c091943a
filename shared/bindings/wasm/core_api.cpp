#include "shared/bindings/wasm/core_api.h"

#include <algorithm>
#include <cstring>
#include <memory>
#include <utility>
#include <vector>

#include "shared/bindings/wasm/core_state.h"
#include "shared/core/scene/bundle_header.h"

using namespace isosplat;
using namespace isosplat::wasm;

namespace {

void put_range(IsosplatCore* core, const CoarseRange& range) {
  put_record(
      core, 0,
      IsosplatCoarseRange{static_cast<double>(range.first_level), static_cast<double>(range.offset),
                          static_cast<double>(range.bytes)});
}

void copy_vector(const Vec3d& vector, double* numbers) {
  numbers[0] = vector.x;
  numbers[1] = vector.y;
  numbers[2] = vector.z;
}

IsosplatStatus open(IsosplatCore* core, std::span<const std::byte> header, StoreKind kind) {
  core->selector.reset();
  core->store.reset();
  auto store = StoreReader::open(header, kind);
  if (!store) return report(core, store.error());
  core->store = std::make_unique<StoreReader>(std::move(*store));
  core->selector.emplace(*core->store);
  return kOk;
}

IsosplatField field_record(const FieldInfo& field, uint64_t offset, uint64_t bytes) {
  IsosplatField record{};
  record.value_offset = field.mapping.offset;
  record.value_scale = field.mapping.scale;
  record.max_error = field.mapping.max_error;
  record.missing_voxels = static_cast<double>(field.missing_voxels);
  record.offset = static_cast<double>(offset);
  record.bytes = static_cast<double>(bytes);
  record.bits = field.mapping.bits;
  record.has_missing = field.mapping.has_missing;
  record.min_quantized = field.range.min;
  record.max_quantized = field.range.max;
  std::copy_n(field.name.begin(), std::min(field.name.size(), sizeof record.name), record.name);
  return record;
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

IsosplatStatus isosplat_core_check_bundle(IsosplatCore* core, const void* header, uint32_t bytes) {
  const auto found = parse_bundle_header(as_bytes(header, bytes));
  return found ? kOk : report(core, found.error());
}

IsosplatStatus isosplat_core_open(IsosplatCore* core, const void* header, uint32_t bytes) {
  return open(core, as_bytes(header, bytes), StoreKind::store);
}

IsosplatStatus isosplat_core_open_field(IsosplatCore* core, const void* header, uint32_t bytes) {
  return open(core, as_bytes(header, bytes), StoreKind::field);
}

IsosplatStatus isosplat_core_set_spacing(IsosplatCore* core, double x, double y, double z) {
  if (!core->store) return no_store(core);
  const auto set = core->store->set_spacing({x, y, z});
  return set ? kOk : report(core, set.error());
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
  std::vector<IsosplatField> fields;
  for (const FieldRef& field : info.fields) {
    fields.push_back(field_record(field.info, field.offset, field.bytes));
  }
  if (info.field) fields.push_back(field_record(*info.field, 0, 0));
  put(core, ISOSPLAT_INFO_FIELDS, fields);
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
  for (const ChunkRef& chunk : *chunks) records.push_back(chunk_record(core, chunk));
  put(core, 0, records);
  return kOk;
}

IsosplatStatus isosplat_core_chunk_at(IsosplatCore* core, uint32_t level, const uint32_t* block,
                                      uint32_t band) {
  if (!core->store) return no_store(core);
  const BlockKey key{level, as_index(block)};
  const auto chunk = core->store->chunk(key, band);
  if (!chunk) {
    const auto page = core->store->page_of(key);
    if (page) put_record(core, 0, *page);
    return report(core, chunk.error());
  }
  put_record(core, 0, chunk_record(core, *chunk));
  return kOk;
}

}  // extern "C"
