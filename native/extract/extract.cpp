#include "native/extract/extract.h"

#include <algorithm>
#include <functional>
#include <tuple>
#include <utility>

#include "native/extract/chunk_reading.h"
#include "shared/core/points/block_borders.h"

namespace isosplat {
namespace {

Result<void> extract_to(const StoreFile& store, double isovalue, const ExtractOptions& options,
                        std::vector<ChunkSamples>& result) {
  const auto chunks = chunks_of(store, isovalue, options);
  if (!chunks) return tl::unexpected(chunks.error());
  result.resize(chunks->size());
  return for_each_chunk(
      store, *chunks, thread_count(options, chunks->size()),
      [&](unsigned, ChunkDecoder& decoder, std::span<const std::byte> bytes, size_t i) {
        result[i].chunk = (*chunks)[i];
        return decoder.decode_packed(bytes, shape_of(store.info(), (*chunks)[i]),
                                     result[i].samples);
      });
}

/// The indices at which the layers of blocks (each with one z) end, in chunks in raster order.
std::vector<size_t> layer_ends(std::span<const ChunkRef> chunks) {
  std::vector<size_t> ends;
  for (size_t i = 0; i < chunks.size(); ++i) {
    const bool is_last = i + 1 == chunks.size();
    if (is_last || chunks[i].block.index.z != chunks[i + 1].block.index.z) ends.push_back(i + 1);
  }
  return ends;
}

std::vector<Index3> blocks_of(std::span<const ChunkRef> chunks) {
  std::vector<Index3> blocks;
  for (const ChunkRef& chunk : chunks) blocks.push_back(chunk.block.index);
  return blocks;
}

/// Computes points layer by layer. A first pass over the chunks of a layer finds the sums at the
/// borders of its blocks; a second pass computes the layer's points, once the borders of the next
/// layer are known. Decoding twice is cheaper than keeping a layer's cells, and needs less memory.
class PointExtraction {
 public:
  PointExtraction(const StoreFile& store, float quantized_isovalue,
                  const ProjectionOptions& projection, const ExtractOptions& options,
                  std::span<const ChunkRef> chunks)
      : store_(store),
        quantized_isovalue_(quantized_isovalue),
        projection_(projection),
        options_(options),
        chunks_(chunks),
        layer_ends_(layer_ends(chunks)),
        borders_(blocks_of(chunks)),
        threads_(thread_count(options, chunks.size())),
        cells_(threads_) {
    if (options.smooth_normals) gradients_.resize(threads_);
    if (options.fields.empty()) return;
    for (unsigned thread = 0; thread < threads_; ++thread) fields_.emplace_back(options.fields);
  }

  Result<uint64_t> run(const std::function<Result<void>(PointsWithFields&&)>& write) {
    uint64_t count = 0;
    for (size_t layer = 0; layer < layer_ends_.size(); ++layer) {
      Result<void> done;
      if (!gradients_.empty()) {
        if (layer == 0) done = find_borders(0);
        if (done && layer + 1 < layer_ends_.size()) done = find_borders(layer + 1);
      }
      if (done) done = write_points(layer, write, count);
      if (!done) return tl::unexpected(done.error());
      if (layer > 0) {
        for (size_t i = layer_begin(layer - 1); i < layer_ends_[layer - 1]; ++i) borders_.clear(i);
      }
    }
    return count;
  }

 private:
  /// Decodes chunks and calls use(thread, index) for each; the cells of a chunk are in
  /// cells_[thread], and their values in fields_[thread].
  template <class Use>
  Result<void> decode(std::span<const ChunkRef> chunks, bool has_fields, const Use& use) {
    return for_each_chunk(store_, chunks, threads_,
                          [&](unsigned thread, ChunkDecoder& decoder,
                              std::span<const std::byte> bytes, size_t i) -> Result<void> {
                            auto decoded = decode_cells(
                                decoder, bytes, chunks[i], shape_of(store_.info(), chunks[i]),
                                options_, cells_[thread], has_fields ? &fields_[thread] : nullptr);
                            if (decoded) use(thread, i);
                            return decoded;
                          });
  }

  size_t layer_begin(size_t layer) const { return layer == 0 ? 0 : layer_ends_[layer - 1]; }

  std::span<const ChunkRef> chunks_of_layer(size_t layer) const {
    return chunks_.subspan(layer_begin(layer), layer_ends_[layer] - layer_begin(layer));
  }

  Result<void> find_borders(size_t layer) {
    return decode(chunks_of_layer(layer), false, [&](unsigned thread, size_t i) {
      borders_.set(layer_begin(layer) + i, gradients_[thread].border_of(cells_[thread]));
    });
  }

  /// The chunks are decoded in batches, whose points are written in order.
  Result<void> write_points(size_t layer,
                            const std::function<Result<void>(PointsWithFields&&)>& write,
                            uint64_t& count) {
    const std::span<const ChunkRef> chunks = chunks_of_layer(layer);
    std::vector<PointsWithFields> points(std::min(kBatchChunks, chunks.size()));
    return for_each_batch(
        chunks,
        [&](std::span<const ChunkRef> batch) {
          return decode(batch, !fields_.empty(), [&](unsigned thread, size_t i) {
            points[i] = points_of(thread, batch[i].block);
          });
        },
        [&](std::span<const ChunkRef>, size_t i) {
          count += points[i].positions.size();
          return write(std::move(points[i]));
        });
  }

  PointsWithFields points_of(unsigned thread, BlockKey block) {
    const DecodedCells& cells = cells_[thread];
    const ChunkFrame frame{&grid_of(store_, options_), &store_.info().mapping, block};
    std::vector<PointPlace> found;
    std::vector<PointPlace>* const places = fields_.empty() ? nullptr : &found;
    PointsWithFields points{
        gradients_.empty()
            ? project_samples(cells, frame, quantized_isovalue_, projection_, nullptr, places)
            : borders_.project(cells, frame, quantized_isovalue_, projection_, gradients_[thread],
                               places),
        {}};
    if (places) points.fields = fields_[thread].at(found);
    return points;
  }

  const StoreFile& store_;
  float quantized_isovalue_;
  const ProjectionOptions& projection_;
  const ExtractOptions& options_;
  std::span<const ChunkRef> chunks_;
  std::vector<size_t> layer_ends_;
  BlockBorders borders_;
  unsigned threads_;
  std::vector<DecodedCells> cells_;          ///< by thread
  std::vector<FieldReader> fields_;          ///< by thread; none if no fields are wanted
  std::vector<LatticeGradients> gradients_;  ///< by thread; all sums are zero between chunks
};

Result<uint64_t> project_chunks(const StoreFile& store, double isovalue,
                                const ProjectionOptions& projection, const ExtractOptions& options,
                                const std::function<Result<void>(PointsWithFields&&)>& write) {
  auto chunks = chunks_of(store, isovalue, options);
  if (!chunks) return tl::unexpected(chunks.error());
  // The builder writes chunks in raster order, but the format does not require it.
  std::ranges::sort(*chunks, {}, [](const ChunkRef& chunk) {
    const Index3 at = chunk.block.index;
    return std::tuple(at.z, at.y, at.x);
  });
  const float quantized_isovalue = store.info().mapping.quantized_isovalue(isovalue);
  return PointExtraction(store, quantized_isovalue, projection, options, *chunks).run(write);
}

}  // namespace

Result<void> extract_samples(const StoreFile& store, double isovalue, const ExtractOptions& options,
                             std::vector<ChunkSamples>& result) {
  auto done =
      catch_out_of_memory(store, [&] { return extract_to(store, isovalue, options, result); });
  if (!done) result.clear();
  return done;
}

Result<uint64_t> extract_points(const StoreFile& store, double isovalue,
                                const ProjectionOptions& projection, const ExtractOptions& options,
                                const std::function<Result<void>(PointsWithFields&&)>& write) {
  return catch_out_of_memory(
      store, [&] { return project_chunks(store, isovalue, projection, options, write); });
}

}  // namespace isosplat
