#include "native/headless/store_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <future>
#include <tuple>

#include "native/headless/field_counts.h"
#include "shared/core/codec/chunk_codec.h"
#include "shared/core/points/field_samples.h"
#include "shared/core/sampling/sample_clusters.h"

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

/// The chunks of a field that belong to these chunks of its store.
Result<std::vector<ChunkRef>> field_chunks_of(const StoreFile& field,
                                              std::span<const ChunkRef> chunks) {
  std::vector<ChunkRef> found;
  for (const ChunkRef& chunk : chunks) {
    const auto of_field = field.chunk(chunk.block, chunk.band);
    if (!of_field) return tl::unexpected(of_field.error());
    found.push_back(*of_field);
  }
  return found;
}

/// Gives the bytes of each of a list of chunks, in their order. Reads them in runs, several of them
/// ahead.
class ChunkBytes {
 public:
  ChunkBytes(const StoreFile& store, std::span<const ChunkRef> chunks, unsigned reads_ahead)
      : store_(store), chunks_(chunks), runs_(store.runs_of(chunks)), reads_ahead_(reads_ahead) {}

  /// Valid until the next call. Errors: those of StoreFile::read_run.
  Result<std::span<const std::byte>> next() {
    if (given_ == given_end_) {
      const ChunkRun run = runs_[given_runs_++];
      auto bytes = next_run();
      if (!bytes) return tl::unexpected(bytes.error());
      bytes_ = std::move(*bytes);
      given_end_ = run.first + run.count;
      run_offset_ = chunks_[run.first].offset;
    }
    const ChunkRef& chunk = chunks_[given_++];
    return std::span<const std::byte>(bytes_).subspan(chunk.offset - run_offset_, chunk.bytes);
  }

 private:
  Result<std::vector<std::byte>> next_run() {
    if (reads_ahead_ == 0) return read(runs_[begun_++]);
    for (; begun_ < runs_.size() && reads_.size() <= reads_ahead_; ++begun_) {
      reads_.push_back(
          std::async(std::launch::async, [this, run = runs_[begun_]] { return read(run); }));
    }
    auto bytes = reads_.front().get();
    reads_.pop_front();
    return bytes;
  }

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
  std::vector<std::byte> bytes_;  // of the run whose chunks are given
  uint64_t run_offset_ = 0;       // in the file
  size_t given_ = 0, given_end_ = 0, given_runs_ = 0;
};

/// Uploads the values of a field with the chunks of its store.
class FieldUpload {
 public:
  FieldUpload(const StoreFile& field, std::vector<ChunkRef> chunks,
              std::span<const float> quantized_isovalues, unsigned reads_ahead)
      : chunks_(std::move(chunks)),
        bytes_(field, chunks_, reads_ahead),
        mapping_(field.info().field->mapping),
        counts_(mapping_, quantized_isovalues) {}

  const FieldCounts& counts() const { return counts_; }
  const ValueMapping& mapping() const { return mapping_; }

  /// Of the next chunk, which has these samples on the GPU, in this order.
  Result<void> add_next(render::Renderer& renderer, ChunkDecoder& decoder, Index3 block_cells,
                        std::span<const PackedSample> samples, ChunkHandle handle,
                        render::VolumeId volume) {
    const auto bytes = bytes_.next();
    if (!bytes) return tl::unexpected(bytes.error());
    const uint32_t value_end = mapping_.bits == 8 ? 256 : 65536;
    auto decoded = decode_field_samples(decoder, *bytes, block_cells, samples, value_end, values_);
    if (!decoded) return decoded;
    counts_.add(samples, values_);
    return renderer.set_chunk_field(handle, values_, volume);
  }

 private:
  const std::vector<ChunkRef> chunks_;
  ChunkBytes bytes_;
  const ValueMapping mapping_;
  FieldCounts counts_;
  std::vector<PackedField> values_;
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
  std::optional<FieldUpload> field;
  if (placed.field) {
    auto of_field = field_chunks_of(*placed.field, chunks);
    if (!of_field) return tl::unexpected(of_field.error());
    std::vector<float> quantized_isovalues;
    for (const double isovalue : isovalues) {
      quantized_isovalues.push_back(info.mapping.quantized_isovalue(isovalue));
    }
    field.emplace(*placed.field, std::move(*of_field), quantized_isovalues, reads_ahead);
    if (auto set = renderer.set_field(field->mapping(), placed.volume); !set) {
      return tl::unexpected(set.error());
    }
  }
  ChunkDecoder decoder;
  std::vector<PackedSample> samples, ordered;
  std::vector<ChunkHandle> handles;
  ChunkBytes reader(store, chunks, reads_ahead);
  for (const ChunkRef& chunk : chunks) {
    const auto bytes = reader.next();
    if (!bytes) return tl::unexpected(bytes.error());
    const ChunkShape shape{block_cells(grid, chunk.block.index), chunk.band_begin, chunk.band_end,
                           chunk.cells, scene.level > 0};
    if (auto decoded = decoder.decode_packed(*bytes, shape, samples); !decoded) {
      return tl::unexpected(decoded.error());
    }
    const auto handle = static_cast<ChunkHandle>(handles.size());
    if (auto added = renderer.add_chunk(handle, chunk.block, samples, placed.volume); !added) {
      return tl::unexpected(added.error());
    }
    handles.push_back(handle);
    if (!field) continue;
    cluster_samples(samples, ordered);
    const auto set =
        field->add_next(renderer, decoder, shape.block_cells, ordered, handle, placed.volume);
    if (!set) return tl::unexpected(set.error());
  }
  if (field) scene.field_range = field->counts().percentiles();
  renderer.set_visible(handles, placed.volume);
  scene.chunks = chunks.size();
  return scene;
}

}  // namespace isosplat
