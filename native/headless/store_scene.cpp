#include "native/headless/store_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <future>
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

/// Reads the runs of a list of chunks, in their order, several of them ahead.
class RunReader {
 public:
  RunReader(const StoreFile& store, std::span<const ChunkRef> chunks, unsigned reads_ahead)
      : store_(store), chunks_(chunks), runs_(store.runs_of(chunks)), reads_ahead_(reads_ahead) {}

  const std::vector<ChunkRun>& runs() const { return runs_; }

  /// The bytes of the next run. Errors: those of StoreFile::read_run.
  Result<std::vector<std::byte>> next() {
    if (reads_ahead_ == 0) return read(runs_[begun_++]);
    for (; begun_ < runs_.size() && reads_.size() <= reads_ahead_; ++begun_) {
      reads_.push_back(
          std::async(std::launch::async, [this, run = runs_[begun_]] { return read(run); }));
    }
    auto bytes = reads_.front().get();
    reads_.pop_front();
    return bytes;
  }

 private:
  Result<std::vector<std::byte>> read(const ChunkRun& run) const {
    std::vector<std::byte> bytes;
    auto done = store_.read_run(chunks_.subspan(run.first, run.count), bytes);
    if (!done) return tl::unexpected(done.error());
    return bytes;
  }

  const StoreFile& store_;
  std::span<const ChunkRef> chunks_;
  const std::vector<ChunkRun> runs_;
  const unsigned reads_ahead_;
  size_t begun_ = 0;  // runs whose reads have begun
  std::deque<std::future<Result<std::vector<std::byte>>>> reads_;
};

}  // namespace

Result<StoreScene> show_store(render::Renderer& renderer, const StoreFile& store,
                              std::span<const double> isovalues, std::optional<uint32_t> level,
                              uint64_t sample_budget, uint32_t finest, const VolumePlace& placed,
                              unsigned reads_ahead) {
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
  std::vector<PackedSample> samples;
  std::vector<ChunkHandle> handles;
  RunReader reader(store, chunks, reads_ahead);
  for (const ChunkRun& each : reader.runs()) {
    const auto run = std::span(chunks).subspan(each.first, each.count);
    const auto bytes = reader.next();
    if (!bytes) return tl::unexpected(bytes.error());
    for (const ChunkRef& chunk : run) {
      const ChunkShape shape{block_cells(grid, chunk.block.index), chunk.band_begin, chunk.band_end,
                             chunk.cells, scene.level > 0};
      const auto part = std::span(*bytes).subspan(chunk.offset - run.front().offset, chunk.bytes);
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
