#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <functional>
#include <mutex>
#include <new>
#include <span>
#include <system_error>
#include <vector>

#include "native/builder/parallel.h"
#include "native/extract/extract.h"
#include "shared/core/codec/chunk_codec.h"
#include "shared/core/points/chunk_shape.h"
#include "shared/system/store_file/store_file.h"

namespace isosplat {

/// The chunks that an isovalue needs at a level, in file order: at most one for each block. Chunks
/// without cells in the region of the options are left out. Errors: see extract_samples.
Result<std::vector<ChunkRef>> chunks_of(const StoreFile& store, double isovalue,
                                        const ExtractOptions& options);

/// The threads to use for this many chunks, at least 1.
unsigned thread_count(const ExtractOptions& options, size_t chunks);

/// The low corner of a block, in cells of its level.
Index3 origin_of(BlockKey block);

/// Decodes a chunk, and removes the cells that are not in the region of the options. `fields`:
/// null, or reads the field chunks as well.
Result<void> decode_cells(ChunkDecoder& decoder, std::span<const std::byte> bytes,
                          const ChunkRef& chunk, const ChunkShape& shape,
                          const ExtractOptions& options, DecodedCells& cells,
                          FieldReader* fields = nullptr);

/// Prefixes the message with the names of the store and the chunk.
Error name_chunk(Error error, const StoreFile& store, const ChunkRef& chunk);

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

/// Reads all chunks and calls process(thread, decoder, bytes, index) for each, on several threads.
/// Verifies the checksums. Processes the largest runs of chunks first, so that all threads end at
/// about the same time.
template <class Process>
Result<void> for_each_chunk(const StoreFile& store, std::span<const ChunkRef> chunks,
                            unsigned threads, const Process& process) {
  std::vector<ChunkRun> runs = store.runs_of(chunks);
  std::ranges::stable_sort(runs, std::greater{}, [&](const ChunkRun& run) {
    uint64_t cells = 0;
    for (const ChunkRef& chunk : chunks.subspan(run.first, run.count)) cells += chunk.cells;
    return cells;
  });
  std::atomic<size_t> next{0};
  FirstError error;
  const auto work = [&](unsigned thread) {
    ChunkDecoder decoder;
    std::vector<std::byte> bytes;
    while (!error.failed()) {
      const size_t turn = next.fetch_add(1);
      if (turn >= runs.size()) return;
      const auto run = chunks.subspan(runs[turn].first, runs[turn].count);
      if (auto read = store.read_run(run, bytes); !read) {
        return error.set(name_chunk(std::move(read.error()), store, run.front()));
      }
      for (size_t i = 0; i < run.size() && !error.failed(); ++i) {
        const auto part =
            std::span(bytes).subspan(run[i].offset - run.front().offset, run[i].bytes);
        auto done = process(thread, decoder, part, runs[turn].first + i);
        if (!done) error.set(name_chunk(std::move(done.error()), store, run[i]));
      }
    }
  };
  on_threads(static_cast<unsigned>(std::clamp<size_t>(runs.size(), 1, threads)), work);
  if (error.failed()) return error.get();
  return {};
}

/// Chunks that are processed before their results are taken in order.
inline constexpr size_t kBatchChunks = 64;

/// Calls `process(batch)` for batches of chunks in order, which is to fill results [0,
/// batch.size()), and then take(batch, i) for each result, in order. Ends with the first error.
template <class Process, class Take>
Result<void> for_each_batch(std::span<const ChunkRef> chunks, const Process& process,
                            const Take& take) {
  for (size_t first = 0; first < chunks.size(); first += kBatchChunks) {
    const auto batch = chunks.subspan(first, std::min(kBatchChunks, chunks.size() - first));
    if (Result<void> done = process(batch); !done) return done;
    for (size_t i = 0; i < batch.size(); ++i) {
      if (Result<void> taken = take(batch, i); !taken) return taken;
    }
  }
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

}  // namespace isosplat
