#include "native/extract/extract.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <mutex>
#include <new>
#include <numeric>
#include <string>
#include <system_error>
#include <thread>
#include <tuple>
#include <utility>

#include "native/builder/parallel.h"

namespace isosplat {
namespace {

ChunkShape shape_of(const StoreInfo& info, const ChunkRef& chunk) {
  const LevelGrid level = level_grid(info.grid.voxels, chunk.block.level);
  return {block_cells(level, chunk.block.index), chunk.band_begin, chunk.band_end, chunk.cells,
          chunk.block.level > 0};
}

Result<std::vector<ChunkRef>> chunks_of(const StoreFile& store, double isovalue,
                                        const ExtractOptions& options) {
  const StoreInfo& info = store.info();
  if (options.level >= info.levels) {
    return fail(Status::not_found,
                fmt::format("{}: expected a level from 0 to {}, found {}: choose another level",
                            store.path().string(), info.levels - 1, options.level));
  }
  if (!std::isfinite(isovalue)) {
    return fail(Status::invalid_argument,
                fmt::format("expected a finite isovalue, found {}", isovalue));
  }
  const float quantized_isovalue = info.mapping.quantized_isovalue(isovalue);
  auto selection = store.chunks_for(options.level, quantized_isovalue, quantized_isovalue);
  if (!selection) return tl::unexpected(selection.error());
  std::erase_if(selection->chunks, [](const ChunkRef& chunk) { return chunk.cells == 0; });
  return std::move(selection->chunks);
}

/// The first error of several threads.
class FirstError {
 public:
  void set(Error error) {
    const std::scoped_lock lock(mutex_);
    if (!failed_.exchange(true)) error_ = std::move(error);
  }
  bool failed() const { return failed_; }
  tl::unexpected<Error> get() { return tl::unexpected(std::move(error_)); }

 private:
  std::mutex mutex_;
  std::atomic<bool> failed_{false};
  Error error_;
};

Error name_chunk(Error error, const StoreFile& store, const ChunkRef& chunk) {
  const Index3 at = chunk.block.index;
  if (!error.message.starts_with(store.path().string())) {
    error.message = fmt::format("{}: chunk {}/{}.{}.{}/{}: {}", store.path().string(),
                                chunk.block.level, at.x, at.y, at.z, chunk.band, error.message);
  }
  return error;
}

unsigned thread_count(const ExtractOptions& options, size_t chunks) {
  const unsigned threads =
      options.threads > 0 ? options.threads : std::max(1u, std::thread::hardware_concurrency());
  return static_cast<unsigned>(std::clamp<size_t>(chunks, 1, threads));
}

/// Reads all chunks and calls process(thread, decoder, bytes, index) for each, on several threads.
/// The checksums are verified. The largest chunks come first, so that all threads end at about the
/// same time.
template <class Process>
Result<void> for_each_chunk(const StoreFile& store, std::span<const ChunkRef> chunks,
                            unsigned threads, const Process& process) {
  std::vector<size_t> order(chunks.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::ranges::sort(order, std::greater{}, [&](size_t i) { return chunks[i].cells; });
  std::atomic<size_t> next{0};
  FirstError error;
  const auto run = [&](unsigned thread) {
    ChunkDecoder decoder;
    std::vector<std::byte> bytes;
    while (!error.failed()) {
      const size_t turn = next.fetch_add(1);
      if (turn >= order.size()) return;
      const size_t i = order[turn];
      bytes.clear();
      Result<void> done = store.read_chunk(chunks[i], bytes);
      if (done) done = process(thread, decoder, bytes, i);
      if (!done) error.set(name_chunk(std::move(done.error()), store, chunks[i]));
    }
  };
  on_threads(static_cast<unsigned>(std::clamp<size_t>(chunks.size(), 1, threads)), run);
  if (error.failed()) return error.get();
  return {};
}

/// Returns extract(), or an error if the system refuses memory or threads.
template <class Extract>
auto catch_out_of_memory(const StoreFile& store, const Extract& extract) -> decltype(extract()) {
  try {
    return extract();
  } catch (const std::bad_alloc&) {
    return fail(Status::out_of_memory,
                fmt::format("{}: the system refused memory while the isosurface was extracted: "
                            "close other programs, or choose a coarser --level",
                            store.path().string()));
  } catch (const std::system_error& error) {
    return fail(
        Status::out_of_memory,
        fmt::format("cannot start the extraction's threads ({}): reduce --threads", error.what()));
  }
}

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
