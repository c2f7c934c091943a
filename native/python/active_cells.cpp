#include "native/python/active_cells.h"

#include "native/extract/chunk_reading.h"
#include "shared/core/points/chunk_shape.h"

namespace isosplat::python {
namespace {

/// Replaces `corners` by those of the active cells of a block.
void find_active(const DecodedCells& cells, Index3 origin, float quantized_isovalue,
                 std::vector<Index3>& corners) {
  corners.clear();
  for (size_t i = 0; i < cells.cell.size(); ++i) {
    if (!is_active(cells.interval[i], quantized_isovalue)) continue;
    const uint32_t cell = cells.cell[i];
    corners.push_back(origin + Index3{static_cast<int32_t>(cell & 63),
                                      static_cast<int32_t>(cell >> 6 & 63),
                                      static_cast<int32_t>(cell >> 12)});
  }
}

Result<std::vector<Index3>> find_all(const StoreFile& store, double isovalue,
                                     const ExtractOptions& options,
                                     const std::function<Result<void>()>& check) {
  const auto chunks = chunks_of(store, isovalue, options);
  if (!chunks) return tl::unexpected(chunks.error());
  const StoreInfo& info = store.info();
  const float quantized_isovalue = info.mapping.quantized_isovalue(isovalue);
  const unsigned threads = thread_count(options, chunks->size());
  std::vector<DecodedCells> decoded_cells(threads);
  std::vector<std::vector<Index3>> found(std::min(kBatchChunks, chunks->size()));
  std::vector<Index3> all;
  const auto find = [&](std::span<const ChunkRef> batch) {
    return for_each_chunk(
        store, batch, threads,
        [&](unsigned thread, ChunkDecoder& decoder, std::span<const std::byte> bytes,
            size_t i) -> Result<void> {
          DecodedCells& cells = decoded_cells[thread];
          const ChunkShape shape = shape_of(info, batch[i]);
          auto decoded = decode_cells(decoder, bytes, batch[i], shape, options, cells);
          if (!decoded) return decoded;
          find_active(cells, origin_of(batch[i].block), quantized_isovalue, found[i]);
          return {};
        });
  };
  const auto take = [&](std::span<const ChunkRef> batch, size_t i) {
    all.insert(all.end(), found[i].begin(), found[i].end());
    return i + 1 == batch.size() ? check() : Result<void>{};
  };
  if (auto done = for_each_batch(*chunks, find, take); !done) return tl::unexpected(done.error());
  return all;
}

}  // namespace

Result<std::vector<Index3>> active_cells(const StoreFile& store, double isovalue,
                                         const ExtractOptions& options,
                                         const std::function<Result<void>()>& check) {
  return catch_out_of_memory(store, [&] { return find_all(store, isovalue, options, check); });
}

}  // namespace isosplat::python
