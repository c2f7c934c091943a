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

/// Reads all chunks and calls process(decoder, bytes, index) for each, on several threads. The
/// checksums are verified. The largest chunks come first, so that all threads end at about the same
/// time.
template <class Process>
Result<void> for_each_chunk(const StoreFile& store, std::span<const ChunkRef> chunks,
                            unsigned threads, const Process& process) {
  std::vector<size_t> order(chunks.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::ranges::sort(order, std::greater{}, [&](size_t i) { return chunks[i].cells; });
  std::atomic<size_t> next{0};
  FirstError error;
  const auto run = [&] {
    ChunkDecoder decoder;
    std::vector<std::byte> bytes;
    while (!error.failed()) {
      const size_t turn = next.fetch_add(1);
      if (turn >= order.size()) return;
      const size_t i = order[turn];
      bytes.clear();
      Result<void> done = store.read_chunk(chunks[i], bytes);
      if (done) done = process(decoder, bytes, i);
      if (!done) error.set(name_chunk(std::move(done.error()), store, chunks[i]));
    }
  };
  if (threads == 0) threads = std::max(1u, std::thread::hardware_concurrency());
  threads = static_cast<unsigned>(std::clamp<size_t>(chunks.size(), 1, threads));
  on_threads(threads, [&](unsigned) { run(); });
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
  return for_each_chunk(store, *chunks, options.threads,
                        [&](ChunkDecoder& decoder, std::span<const std::byte> bytes, size_t i) {
                          result[i].chunk = (*chunks)[i];
                          return decoder.decode_packed(bytes, shape_of(store.info(), (*chunks)[i]),
                                                       result[i].samples);
                        });
}

Result<uint64_t> project_chunks(const StoreFile& store, double isovalue,
                                const ProjectionOptions& projection, const ExtractOptions& options,
                                const std::function<Result<void>(const PointArrays&)>& write) {
  const auto chunks = chunks_of(store, isovalue, options);
  if (!chunks) return tl::unexpected(chunks.error());
  const StoreInfo& info = store.info();
  const float quantized_isovalue = info.mapping.quantized_isovalue(isovalue);
  constexpr size_t kBatchChunks = 64;
  uint64_t count = 0;
  std::vector<PointArrays> points(kBatchChunks);
  for (size_t first = 0; first < chunks->size(); first += kBatchChunks) {
    const auto batch =
        std::span(*chunks).subspan(first, std::min(kBatchChunks, chunks->size() - first));
    auto done = for_each_chunk(
        store, batch, options.threads,
        [&](ChunkDecoder& decoder, std::span<const std::byte> bytes, size_t i) -> Result<void> {
          DecodedCells cells;
          auto decoded = decoder.decode(bytes, shape_of(info, batch[i]), cells);
          if (!decoded) return decoded;
          points[i] = project_samples(cells, {&info.grid, &info.mapping, batch[i].block},
                                      quantized_isovalue, projection);
          return {};
        });
    if (!done) return tl::unexpected(done.error());
    for (size_t i = 0; i < batch.size(); ++i) {
      count += points[i].positions.size();
      if (auto written = write(points[i]); !written) return tl::unexpected(written.error());
    }
  }
  return count;
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
