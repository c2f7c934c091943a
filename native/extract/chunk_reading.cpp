#include "native/extract/chunk_reading.h"

#include <cmath>
#include <thread>

namespace isosplat {

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
  std::erase_if(selection->chunks, [&](const ChunkRef& chunk) {
    if (chunk.cells == 0) return true;
    const Index3 cells = shape_of(info, chunk).block_cells;
    return options.region &&
           !options.region->may_contain(origin_of(chunk.block), cells, options.level);
  });
  return std::move(selection->chunks);
}

unsigned thread_count(const ExtractOptions& options, size_t chunks) {
  const unsigned threads =
      options.threads > 0 ? options.threads : std::max(1u, std::thread::hardware_concurrency());
  return static_cast<unsigned>(std::clamp<size_t>(chunks, 1, threads));
}

Index3 origin_of(BlockKey block) {
  const Index3 at = block.index;
  return {at.x * kBlockCells, at.y * kBlockCells, at.z * kBlockCells};
}

Result<void> decode_cells(ChunkDecoder& decoder, std::span<const std::byte> bytes,
                          const ChunkRef& chunk, const ChunkShape& shape,
                          const ExtractOptions& options, DecodedCells& cells, FieldReader* fields) {
  auto decoded = decoder.decode(bytes, shape, cells);
  // All cells of the chunk are needed to decode its field chunks.
  if (decoded && fields) decoded = fields->read(decoder, chunk, shape.block_cells, cells.cell);
  if (decoded && options.region) {
    options.region->keep(cells, origin_of(chunk.block), chunk.block.level);
  }
  return decoded;
}

Error name_chunk(Error error, const StoreFile& store, const ChunkRef& chunk) {
  const Index3 at = chunk.block.index;
  if (!error.message.starts_with(store.path().string())) {
    error.message = fmt::format("{}: chunk {}/{}.{}.{}/{}: {}", store.path().string(),
                                chunk.block.level, at.x, at.y, at.z, chunk.band, error.message);
  }
  return error;
}

}  // namespace isosplat
