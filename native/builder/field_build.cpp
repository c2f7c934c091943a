#include "native/builder/field_build.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

#include "native/builder/file_slices.h"
#include "native/builder/layer_blocks.h"
#include "native/builder/no_sink.h"
#include "native/builder/refusals.h"
#include "native/builder/thread_executor.h"
#include "shared/core/builder/metadata.h"
#include "shared/core/preprocess/coarsen.h"
#include "shared/core/preprocess/picked_levels.h"
#include "shared/core/store/field_sections.h"
#include "shared/core/store/format.h"

namespace isosplat {
namespace {

/// Writes the blocks of layers in raster order, whatever the order in which they are added.
class OrderedBlocks {
 public:
  explicit OrderedBlocks(StoreWriter& writer) : writer_(writer) {}

  /// Adds block `number` of the layer. Several threads may call it. Errors: those of the writer.
  Result<void> add(size_t number, EncodedBlock&& block) {
    const std::lock_guard lock(mutex_);
    waiting_.emplace(number, std::move(block));
    for (auto first = waiting_.begin(); first != waiting_.end() && first->first == next_;
         first = waiting_.erase(first), ++next_) {
      const EncodedBlock& next = first->second;
      if (auto added = writer_.add_block(next.interval, next.bands, next.bytes); !added) {
        return added;
      }
    }
    return {};
  }

  void end_layer() { next_ = 0; }

 private:
  StoreWriter& writer_;
  std::mutex mutex_;
  std::map<size_t, EncodedBlock> waiting_;
  size_t next_ = 0;
};

/// Encodes the chunks of a field, block by block. One object per thread.
class FieldEncoder {
 public:
  explicit FieldEncoder(const StoreFile& store) : store_(store) {}

  /// Encodes a block of the field, and writes its part of the coarser level. Errors: those of
  /// StoreFile and ChunkDecoder.
  Result<void> encode(const Layer& layer, const CoarserLayer& coarser, Index3 index,
                      EncodedBlock& out) {
    gather_block(layer, index, block_);
    if (coarser.voxels) coarsen_block(layer, block_, coarser);
    const auto block = store_.block({layer.grid.level, index});
    if (!block) return tl::unexpected(block.error());
    out.interval = block->interval;
    for (uint32_t band = 0; band < block->band_count; ++band) {
      const auto chunk = store_.chunk(block->key, band);
      if (!chunk) return tl::unexpected(chunk.error());
      const size_t before = out.bytes.size();
      if (chunk->cells > 0) {
        if (auto encoded = encode_chunk(*chunk, layer.bits, out.bytes); !encoded) return encoded;
      }
      out.bands.push_back(
          {chunk->band_end, chunk->cells, static_cast<uint32_t>(out.bytes.size() - before)});
    }
    return {};
  }

 private:
  Result<void> encode_chunk(const ChunkRef& chunk, uint8_t bits, std::vector<std::byte>& out) {
    bytes_.clear();
    if (auto read = store_.read_chunk(chunk, bytes_); !read) return read;
    const ChunkShape shape{block_.cells, chunk.band_begin, chunk.band_end, chunk.cells,
                           chunk.block.level > 0};
    if (auto decoded = decoder_.decode(bytes_, shape, cells_); !decoded) return decoded;
    mask_.set(cells_.cell, block_.cells);
    encoder_.encode_field({block_.cells, block_.voxels.data()}, mask_, 1u << bits, out);
    return {};
  }

  const StoreFile& store_;
  GatheredBlock block_;
  std::vector<std::byte> bytes_;
  ChunkDecoder decoder_;
  DecodedCells cells_;
  CellMask mask_;
  ChunkEncoder encoder_;
};

/// One thread's part of a layer.
void encode_blocks(StoreBuild& build, LayerBlocks& blocks, FieldEncoder& encoder,
                   OrderedBlocks& output) {
  while (const auto task = blocks.begin()) {
    EncodedBlock encoded;
    auto done = encoder.encode(build.layer(), build.coarser(), task->index, encoded);
    if (done) done = output.add(task->number, std::move(encoded));
    if (!done) return blocks.fail(done.error());
    EncodedBlock nothing;  // the build itself writes no chunks
    nothing.storage_weight = task->options.storage_weight;
    blocks.add(task->number, std::move(nothing));
  }
}

Result<void> encode_layers(StoreBuild& build, const StoreFile& store, unsigned threads,
                           StoreWriter& writer) {
  OrderedBlocks output(writer);
  std::vector<FieldEncoder> encoders;
  for (unsigned t = 0; t < threads; ++t) encoders.emplace_back(store);
  for (;;) {
    const auto has_layer = build.next_layer();
    if (!has_layer) return tl::unexpected(has_layer.error());
    if (!*has_layer) return {};
    LayerBlocks blocks(build);
    on_threads(threads, [&](unsigned thread) {
      try {
        encode_blocks(build, blocks, encoders[thread], output);
      } catch (...) {
        blocks.stop();  // other threads may wait there for this thread's block
        throw;
      }
    });
    if (!blocks.result()) return blocks.result();
    if (build.is_last_band()) output.end_layer();
  }
}

/// The metadata of a volume without what concerns its isosurfaces, and with categories.
std::string field_metadata(const std::string& of_volume, const std::string& categories) {
  auto json = nlohmann::ordered_json::parse(of_volume, nullptr, false);
  if (!json.is_object()) return "{}";
  json.erase("suggested_isovalues");
  json.erase("active_cells");
  if (!categories.empty()) {
    json.erase("histogram");
    json["categories"] = nlohmann::ordered_json::parse(categories);
  }
  std::string text = json.dump(-1, ' ', true);
  if (text.size() <= kMaxMetadataBytes) return text;
  json.erase("notes");
  return json.dump(-1, ' ', true);
}

Result<FieldInfo> build_on_threads(const StoreFile& store, const std::string& name,
                                   VolumeSource& source, ByteSink& sink,
                                   const BuildOptions& options,
                                   std::span<const Category> categories) {
  StoreInfo info = store.info();
  info.fields.clear();
  info.field.emplace().name = name;
  if (auto checked = check_field(*info.field); !checked) return tl::unexpected(checked.error());
  const VolumeHeader& header = source.header();
  auto same_grid = check_field_grid(name, info.grid.voxels, header.grid.voxels);
  if (!same_grid) return tl::unexpected(same_grid.error());

  StoreOptions of_field;
  of_field.max_error = options.max_error;
  of_field.memory_bytes = options.memory_bytes;
  of_field.notes = options.notes;
  of_field.source_file = options.source_file;
  static const PickedLevels kPicked;
  if (!categories.empty()) of_field.coarse_levels = &kPicked;
  of_field.progress = options.progress;
  const std::string categories_text = categories.empty() ? "" : categories_json(categories);
  constexpr size_t kKey = sizeof R"(,"categories":)";
  const size_t metadata_bytes =
      std::min(kMaxMetadataBytes, metadata_limit(header, of_field) + kKey + categories_text.size());
  auto writer =
      StoreWriter::create(info.grid.voxels, metadata_bytes, sink, field_sections_bytes(info));
  if (!writer) return tl::unexpected(writer.error());
  ThreadExecutor executor(thread_count(options));
  FileSliceStorage storage(options.temporary_folder.empty() ? std::filesystem::temp_directory_path()
                                                            : options.temporary_folder);
  NoSink no_sink;
  StoreBuild build(source, no_sink, of_field, executor, executor.threads(), &storage);
  if (auto begun = build.begin(); !begun) return tl::unexpected(begun.error());
  auto encoded = encode_layers(build, store, executor.threads(), *writer);
  if (!encoded) return tl::unexpected(encoded.error());
  const auto built = build.finish(VolumeStatistics());
  if (!built) return tl::unexpected(built.error());
  info.metadata = field_metadata(built->info.metadata, categories_text);
  info.field = {name, built->info.mapping, built->info.range, built->info.missing_voxels};
  auto finished = writer->finish(info);
  if (!finished) return tl::unexpected(finished.error());
  return *info.field;
}

}  // namespace

Result<void> check_field_grid(const std::string& name, Index3 store, Index3 field) {
  if (store == field) return {};
  return fail(Status::invalid_argument,
              fmt::format("field '{}': expected {} × {} × {} voxels, as the volume has, found {} × "
                          "{} × {}: resample it to the grid of the volume",
                          name, store.x, store.y, store.z, field.x, field.y, field.z));
}

Result<FieldInfo> build_field(const StoreFile& store, const std::string& name, VolumeSource& source,
                              ByteSink& sink, const BuildOptions& options,
                              std::span<const Category> categories) {
  return with_refusals(
      [&] { return build_on_threads(store, name, source, sink, options, categories); });
}

}  // namespace isosplat
