#include "native/headless/store_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>

#include "shared/core/codec/chunk_codec.h"

namespace isosplat {
namespace {

/// The chunks of a level that any of the isovalues needs, each once.
Result<std::vector<ChunkRef>> chunks_at(const StoreFile& store, std::span<const double> isovalues,
                                        uint32_t level) {
  std::vector<ChunkRef> chunks;
  for (const double isovalue : isovalues) {
    const float quantized_isovalue = store.info().mapping.quantized_isovalue(isovalue);
    auto selection = store.chunks_for(level, quantized_isovalue, quantized_isovalue);
    if (!selection) return tl::unexpected(selection.error());
    chunks.insert(chunks.end(), selection->chunks.begin(), selection->chunks.end());
  }
  const auto key = [](const ChunkRef& chunk) { return chunk.offset; };
  std::sort(chunks.begin(), chunks.end(),
            [&](const ChunkRef& a, const ChunkRef& b) { return key(a) < key(b); });
  chunks.erase(std::unique(chunks.begin(), chunks.end(),
                           [&](const ChunkRef& a, const ChunkRef& b) { return key(a) == key(b); }),
               chunks.end());
  return chunks;
}

}  // namespace

Result<StoreScene> show_store(render::Renderer& renderer, const StoreFile& store,
                              std::span<const double> isovalues, std::optional<uint32_t> level,
                              uint64_t sample_budget, uint32_t finest, const VolumePlace& placed) {
  const StoreInfo& info = store.info();
  if (level && *level >= info.levels) {
    return fail(Status::not_found,
                fmt::format("{}: expected a level from 0 to {}, found {}: choose another level",
                            store.path().string(), info.levels - 1, *level));
  }
  StoreScene scene;
  scene.level = level.value_or(std::min(finest, info.levels - 1));
  std::vector<ChunkRef> chunks;
  for (;; ++scene.level) {
    auto found = chunks_at(store, isovalues, scene.level);
    if (!found) return tl::unexpected(found.error());
    chunks = std::move(*found);
    scene.samples = 0;
    for (const ChunkRef& chunk : chunks) scene.samples += chunk.cells;
    if (level || scene.samples <= sample_budget || scene.level + 1 == info.levels) break;
  }

  renderer.set_volume(placed.grid.value_or(info.grid), info.mapping, placed.volume);
  const LevelGrid grid = level_grid(info.grid.voxels, scene.level);
  ChunkDecoder decoder;
  std::vector<std::byte> bytes;
  std::vector<PackedSample> samples;
  std::vector<ChunkHandle> handles;
  for (const ChunkRun& each : store.runs_of(chunks)) {
    const auto run = std::span(chunks).subspan(each.first, each.count);
    if (auto read = store.read_run(run, bytes); !read) return tl::unexpected(read.error());
    for (const ChunkRef& chunk : run) {
      const ChunkShape shape{block_cells(grid, chunk.block.index), chunk.band_begin, chunk.band_end,
                             chunk.cells, scene.level > 0};
      const auto part = std::span(bytes).subspan(chunk.offset - run.front().offset, chunk.bytes);
      if (auto decoded = decoder.decode_packed(part, shape, samples); !decoded) {
        return tl::unexpected(decoded.error());
      }
      const auto handle = static_cast<ChunkHandle>(handles.size());
      if (auto added = renderer.add_chunk(handle, chunk.block, samples, placed.volume); !added) {
        return tl::unexpected(added.error());
      }
      handles.push_back(handle);
    }
  }
  renderer.set_visible(handles, placed.volume);
  scene.chunks = chunks.size();
  return scene;
}

}  // namespace isosplat
