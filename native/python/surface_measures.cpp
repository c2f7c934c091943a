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
  constexpr size_t kBatchChunks = 64;
  const auto chunks = chunks_of(store, isovalue, options);
  if (!chunks) return tl::unexpected(chunks.error());
  const StoreInfo& info = store.info();
  const float quantized_isovalue = info.mapping.quantized_isovalue(isovalue);
  const unsigned threads = thread_count(options, chunks->size());
  std::vector<BlockMesher> meshers(threads);
  std::vector<MeasuredBlock> blocks(std::min(kBatchChunks, chunks->size()));
  SurfaceExtent extent(info.grid, quantized_isovalue, info.range.min);
  for (size_t first = 0; first < chunks->size(); first += kBatchChunks) {
    const auto batch =
        std::span(*chunks).subspan(first, std::min(kBatchChunks, chunks->size() - first));
    auto meshed = for_each_chunk(
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
    if (!meshed) return tl::unexpected(meshed.error());
    for (size_t i = 0; i < batch.size(); ++i) {
      extent.add(blocks[i].cells, blocks[i].mesh, origin_of(batch[i].block));
    }
    if (auto go_on = check(); !go_on) return tl::unexpected(go_on.error());
  }
  return SurfaceMeasures{extent.area(), extent.volume_above()};
}

}  // namespace

Result<SurfaceMeasures> measure_surface(const StoreFile& store, double isovalue,
                                        const ExtractOptions& options,
                                        const std::function<Result<void>()>& check) {
  return catch_out_of_memory(store, [&] { return measure(store, isovalue, options, check); });
}

}  // namespace isosplat::python
