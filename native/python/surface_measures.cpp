#include "native/python/surface_measures.h"

#include "native/extract/chunk_reading.h"
#include "shared/core/mesh/block_mesh.h"
#include "shared/core/mesh/surface_extent.h"
#include "shared/core/points/chunk_shape.h"

namespace isosplat::python {
namespace {

/// The surface in one block.
struct MeasuredBlock {
  DecodedCells cells;
  BlockMesh mesh;
};

Result<SurfaceMeasures> measure(const StoreFile& store, double isovalue,
                                const ExtractOptions& options,
                                const std::function<Result<void>()>& check) {
  // Sums are in the order of the chunks, so that they do not depend on threads.
  const auto chunks = chunks_of(store, isovalue, options);
  if (!chunks) return tl::unexpected(chunks.error());
  const StoreInfo& info = store.info();
  const float quantized_isovalue = info.mapping.quantized_isovalue(isovalue);
  const unsigned threads = thread_count(options, chunks->size());
  std::vector<BlockMesher> meshers(threads);
  std::vector<MeasuredBlock> blocks(std::min(kBatchChunks, chunks->size()));
  SurfaceExtent extent(info.grid, quantized_isovalue, info.range.min);
  const auto mesh = [&](std::span<const ChunkRef> batch) {
    return for_each_chunk(
        store, batch, threads,
        [&](unsigned thread, ChunkDecoder& decoder, std::span<const std::byte> bytes,
            size_t i) -> Result<void> {
          MeasuredBlock& block = blocks[i];
          const ChunkShape shape = shape_of(info, batch[i]);
          auto decoded = decode_cells(decoder, bytes, batch[i], shape, options, block.cells);
          if (!decoded) return decoded;
          meshers[thread].run(block.cells, shape.block_cells, origin_of(batch[i].block),
                              quantized_isovalue, block.mesh);
          return {};
        });
  };
  const auto take = [&](std::span<const ChunkRef> batch, size_t i) {
    extent.add(blocks[i].cells, blocks[i].mesh, origin_of(batch[i].block));
    return i + 1 == batch.size() ? check() : Result<void>{};
  };
  if (auto done = for_each_batch(*chunks, mesh, take); !done) return tl::unexpected(done.error());
  return SurfaceMeasures{extent.area(), extent.volume_above()};
}

}  // namespace

Result<SurfaceMeasures> measure_surface(const StoreFile& store, double isovalue,
                                        const ExtractOptions& options,
                                        const std::function<Result<void>()>& check) {
  return catch_out_of_memory(store, [&] { return measure(store, isovalue, options, check); });
}

}  // namespace isosplat::python
