#include "native/extract/extract.h"

#include <algorithm>
#include <functional>
#include <tuple>
#include <utility>

#include "native/extract/chunk_reading.h"

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

/// The chunks of one layer of blocks (one z), in raster order, and the sums of gradients at the
/// borders of their blocks.
struct Layer {
  std::span<const ChunkRef> chunks;
  std::vector<BlockBorder> borders;  ///< one per chunk; empty until they are computed

  const BlockBorder* border_of(Index3 block) const {
    const auto found = std::ranges::lower_bound(
        chunks, std::pair(block.y, block.x), {},
        [](const ChunkRef& chunk) { return std::pair(chunk.block.index.y, chunk.block.index.x); });
    if (borders.empty() || found == chunks.end() || found->block.index != block) return nullptr;
    return &borders[static_cast<size_t>(found - chunks.begin())];
  }
};

/// Cuts chunks in raster order of blocks into layers.
std::vector<Layer> layers_of(std::span<const ChunkRef> chunks) {
  std::vector<Layer> layers;
  for (size_t first = 0; first < chunks.size();) {
    size_t end = first;
    while (end < chunks.size() && chunks[end].block.index.z == chunks[first].block.index.z) ++end;
    layers.push_back({chunks.subspan(first, end - first), {}});
    first = end;
  }
  return layers;
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
        layers_(layers_of(chunks)),
        threads_(thread_count(options, chunks.size())),
        cells_(threads_) {
    if (options.smooth_normals) gradients_.resize(threads_);
  }

  Result<uint64_t> run(const std::function<Result<void>(const PointArrays&)>& write) {
    uint64_t count = 0;
    for (size_t i = 0; i < layers_.size(); ++i) {
      Result<void> done;
      if (!gradients_.empty()) {
        if (i == 0) done = find_borders(layers_[0]);
        if (done && i + 1 < layers_.size()) done = find_borders(layers_[i + 1]);
      }
      if (done) done = write_points(i, write, count);
      if (!done) return tl::unexpected(done.error());
      if (i > 0) layers_[i - 1].borders = {};
    }
    return count;
  }

 private:
  /// Decodes chunks and calls use(thread, index) for each; its cells are cells_[thread].
  template <class Use>
  Result<void> decode(std::span<const ChunkRef> chunks, const Use& use) {
    return for_each_chunk(store_, chunks, threads_,
                          [&](unsigned thread, ChunkDecoder& decoder,
                              std::span<const std::byte> bytes, size_t i) -> Result<void> {
                            auto decoded = decoder.decode(bytes, shape_of(store_.info(), chunks[i]),
                                                          cells_[thread]);
                            if (decoded) use(thread, i);
                            return decoded;
                          });
  }

  Result<void> find_borders(Layer& layer) {
    layer.borders.resize(layer.chunks.size());
    return decode(layer.chunks, [&](unsigned thread, size_t i) {
      layer.borders[i] = gradients_[thread].border_of(cells_[thread]);
    });
  }

  /// The chunks are decoded in batches, whose points are written in order.
  Result<void> write_points(size_t layer,
                            const std::function<Result<void>(const PointArrays&)>& write,
                            uint64_t& count) {
    constexpr size_t kBatchChunks = 64;
    const std::span<const ChunkRef> chunks = layers_[layer].chunks;
    std::vector<PointArrays> points(std::min(kBatchChunks, chunks.size()));
    for (size_t first = 0; first < chunks.size(); first += kBatchChunks) {
      const auto batch = chunks.subspan(first, std::min(kBatchChunks, chunks.size() - first));
      auto done = decode(batch, [&](unsigned thread, size_t i) {
        points[i] = points_of(thread, layer, batch[i].block);
      });
      if (!done) return done;
      for (size_t i = 0; i < batch.size(); ++i) {
        count += points[i].positions.size();
        if (auto written = write(points[i]); !written) return written;
      }
    }
    return {};
  }

  PointArrays points_of(unsigned thread, size_t layer, BlockKey block) {
    const DecodedCells& cells = cells_[thread];
    const ChunkFrame frame{&store_.info().grid, &store_.info().mapping, block};
    if (gradients_.empty()) return project_samples(cells, frame, quantized_isovalue_, projection_);
    LatticeGradients& gradients = gradients_[thread];
    gradients.add(cells);
    for_neighbours(layer, block, [&](const BlockBorder& border, Index3 offset) {
      gradients.add(border, offset);
    });
    PointArrays points =
        project_samples(cells, frame, quantized_isovalue_, projection_, &gradients);
    gradients.remove(cells);
    for_neighbours(layer, block, [&](const BlockBorder& border, Index3 offset) {
      gradients.remove(border, offset);
    });
    return points;
  }

  /// Calls f(border, offset) for the up to 26 neighbours that have a chunk.
  template <class F>
  void for_neighbours(size_t layer, BlockKey block, const F& f) const {
    // The layers before and after in the list may be further away than one block.
    const size_t end = std::min(layer + 2, layers_.size());
    for (size_t i = layer > 0 ? layer - 1 : 0; i < end; ++i) {
      const int32_t dz = layers_[i].chunks.front().block.index.z - block.index.z;
      if (dz < -1 || dz > 1) continue;
      for (int32_t dy = -1; dy <= 1; ++dy) {
        for (int32_t dx = -1; dx <= 1; ++dx) {
          const Index3 offset{dx, dy, dz};
          if (offset == Index3{}) continue;
          if (const BlockBorder* border = layers_[i].border_of(block.index + offset)) {
            f(*border, offset);
          }
        }
      }
    }
  }

  const StoreFile& store_;
  float quantized_isovalue_;
  const ProjectionOptions& projection_;
  std::vector<Layer> layers_;
  unsigned threads_;
  std::vector<DecodedCells> cells_;          ///< by thread
  std::vector<LatticeGradients> gradients_;  ///< by thread; all sums are zero between chunks
};

Result<uint64_t> project_chunks(const StoreFile& store, double isovalue,
                                const ProjectionOptions& projection, const ExtractOptions& options,
                                const std::function<Result<void>(const PointArrays&)>& write) {
  auto chunks = chunks_of(store, isovalue, options);
  if (!chunks) return tl::unexpected(chunks.error());
  // The builder writes raster order, but the format does not demand it.
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
                                const std::function<Result<void>(const PointArrays&)>& write) {
  return catch_out_of_memory(
      store, [&] { return project_chunks(store, isovalue, projection, options, write); });
}

}  // namespace isosplat
