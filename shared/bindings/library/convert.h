#pragma once

#include "isosplat/store.h"
#include "shared/core/store/store_reader.h"

// Converts between the public types (shared/core/include/isosplat) and the types of the core.
namespace isosplat {

Volume volume_of(const StoreInfo& info);
VolumeGrid grid_of(const Volume& volume);
ValueMapping mapping_of(const Volume& volume);

Chunk chunk_of(const ChunkRef& ref);
ChunkRef chunk_ref_of(const Chunk& chunk);

/// Converts the chunks, without those that have no cells: the bands of values that do not occur.
std::vector<Chunk> chunks_of(const std::vector<ChunkRef>& refs);

/// Errors: not_found (no such level), invalid_argument (the isovalue is not a finite number).
Result<void> check_query(const Volume& volume, uint32_t level, double isovalue);

}  // namespace isosplat
