#pragma once

#include "shared/core/codec/chunk_codec.h"
#include "shared/core/store/store_reader.h"

namespace isosplat {

/// The properties of a chunk of a store that the decoder needs.
inline ChunkShape shape_of(const StoreInfo& info, const ChunkRef& chunk) {
  const LevelGrid level = level_grid(info.grid.voxels, chunk.block.level);
  return {block_cells(level, chunk.block.index), chunk.band_begin, chunk.band_end, chunk.cells,
          chunk.block.level > 0};
}

}  // namespace isosplat
