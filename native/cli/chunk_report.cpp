#include "native/cli/chunk_report.h"

#include <algorithm>
#include <cmath>

#include "native/extract/extract.h"
#include "shared/system/store_file/field_file.h"

namespace isosplat::cli {
namespace {

std::array<uint32_t, 7> quantiles(std::vector<uint32_t> values) {
  std::array<uint32_t, 7> result{};
  if (values.empty()) return result;
  std::sort(values.begin(), values.end());
  for (size_t i = 0; i < result.size(); ++i) {
    const double at = ChunkReport::kQuantiles[i] * static_cast<double>(values.size() - 1);
    result[i] = values[static_cast<size_t>(std::lround(at))];
  }
  return result;
}

Result<ChunkReport::Level> report_level(const StoreFile& store, uint32_t level) {
  ChunkReport::Level result;
  std::vector<uint32_t> sizes, bands;
  const Index3 blocks = level_grid(store.info().grid.voxels, level).blocks;
  for (int32_t z = 0; z < blocks.z; ++z) {
    for (int32_t y = 0; y < blocks.y; ++y) {
      for (int32_t x = 0; x < blocks.x; ++x) {
        const BlockKey key{level, {x, y, z}};
        const auto block = store.block(key);
        if (!block) return tl::unexpected(block.error());
        if (block->band_count == 0) {
          ++result.empty_blocks;
          continue;
        }
        ++result.blocks;
        bands.push_back(block->band_count);
        for (uint32_t band = 0; band < block->band_count; ++band) {
          const auto chunk = store.chunk(key, band);
          if (!chunk) return tl::unexpected(chunk.error());
          if (chunk->cells == 0) continue;
          ++result.chunks;
          result.bytes += chunk->bytes;
          result.cells += chunk->cells;
          sizes.push_back(chunk->bytes);
        }
      }
    }
  }
  result.chunk_bytes = quantiles(std::move(sizes));
  result.block_bands = quantiles(std::move(bands));
  return result;
}

/// Bytes of the field chunks that belong to chunks.
Result<uint64_t> field_bytes_of(const StoreFile& field, const std::vector<ChunkSamples>& chunks) {
  uint64_t bytes = 0;
  for (const ChunkSamples& of_store : chunks) {
    const auto chunk = field.chunk(of_store.chunk.block, of_store.chunk.band);
    if (!chunk) return tl::unexpected(chunk.error());
    bytes += chunk->bytes;
  }
  return bytes;
}

}  // namespace

Result<ChunkReport> report_chunks(const StoreFile& store, const std::vector<double>& isovalues) {
  ChunkReport report;
  for (uint32_t level = 0; level < store.info().levels; ++level) {
    auto statistics = report_level(store, level);
    if (!statistics) return tl::unexpected(statistics.error());
    report.levels.push_back(*statistics);
  }
  std::vector<std::shared_ptr<StoreFile>> fields;
  for (size_t i = 0; i < store.info().fields.size(); ++i) {
    auto field = open_field(store, i);
    if (!field) return tl::unexpected(field.error());
    fields.push_back(std::move(*field));
    report.fields.push_back(store.info().fields[i].info.name);
  }
  std::vector<ChunkSamples> chunks;
  for (const double isovalue : isovalues) {
    if (auto extracted = extract_samples(store, isovalue, {}, chunks); !extracted) {
      return tl::unexpected(extracted.error());
    }
    ChunkReport::Query query;
    query.isovalue = isovalue;
    const float quantized_isovalue = store.info().mapping.quantized_isovalue(isovalue);
    for (const ChunkSamples& chunk : chunks) {
      ++query.chunks;
      query.bytes += chunk.chunk.bytes;
      query.fetched_cells += chunk.samples.size();
      for (const PackedSample& sample : chunk.samples) {
        const CellInterval interval{static_cast<QuantizedValue>(sample.word[1] & 0xffff),
                                    static_cast<QuantizedValue>(sample.word[1] >> 16)};
        query.active_cells += is_active(interval, quantized_isovalue);
      }
    }
    for (const auto& field : fields) {
      const auto bytes = field_bytes_of(*field, chunks);
      if (!bytes) return tl::unexpected(bytes.error());
      query.field_bytes.push_back(*bytes);
    }
    report.queries.push_back(std::move(query));
  }
  return report;
}

}  // namespace isosplat::cli
