#pragma once

#include <array>
#include <vector>

#include "shared/store_file/store_file.h"

namespace isosplat::cli {

/// How a store's chunks are distributed: what the cuts and the codec lead to.
struct ChunkReport {
  struct Level {
    uint64_t blocks = 0;        ///< with at least one chunk
    uint64_t empty_blocks = 0;  ///< without
    uint64_t chunks = 0, bytes = 0, cells = 0;
    std::array<uint32_t, 7> chunk_bytes{};  ///< at kQuantiles
    std::array<uint32_t, 7> block_bands{};  ///< per block with chunks, at kQuantiles
  };
  static constexpr std::array<double, 7> kQuantiles = {0, 0.05, 0.25, 0.5, 0.75, 0.95, 1};

  /// What one isovalue takes at level 0.
  struct Query {
    double isovalue = 0;
    uint64_t chunks = 0, bytes = 0;
    uint64_t fetched_cells = 0;
    uint64_t active_cells = 0;
  };

  std::vector<Level> levels;
  std::vector<Query> queries;
};

/// Walks the whole directory, and decodes what the isovalues need at level 0. Errors: those of
/// StoreFile and ChunkDecoder.
Result<ChunkReport> report_chunks(const StoreFile& store, const std::vector<double>& isovalues);

}  // namespace isosplat::cli
