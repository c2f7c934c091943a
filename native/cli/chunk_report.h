#pragma once

#include <array>
#include <string>
#include <vector>

#include "shared/system/store_file/store_file.h"

namespace isosplat::cli {

/// Statistics of a store's chunks: the result of the bands and the codec.
struct ChunkReport {
  struct Level {
    uint64_t blocks = 0;        ///< with at least one band
    uint64_t empty_blocks = 0;  ///< without bands
    uint64_t chunks = 0, bytes = 0, cells = 0;
    std::array<uint32_t, 7> chunk_bytes{};  ///< sizes of chunks, at kQuantiles
    std::array<uint32_t, 7> block_bands{};  ///< bands per block that has any, at kQuantiles
  };
  static constexpr std::array<double, 7> kQuantiles = {0, 0.05, 0.25, 0.5, 0.75, 0.95, 1};

  /// The chunks of level 0 that one isovalue needs.
  struct Query {
    double isovalue = 0;
    uint64_t chunks = 0, bytes = 0;
    uint64_t fetched_cells = 0;              ///< all cells of these chunks
    uint64_t active_cells = 0;               ///< those that the isosurface crosses
    std::vector<uint64_t> field_bytes = {};  ///< of the field chunks of these chunks, by field
  };

  std::vector<Level> levels;
  std::vector<Query> queries;
  std::vector<std::string> fields;  ///< names of the store's fields
};

/// Reads the whole directory, and decodes the chunks of level 0 that the isovalues need. Errors:
/// those of StoreFile and ChunkDecoder.
Result<ChunkReport> report_chunks(const StoreFile& store, const std::vector<double>& isovalues);

}  // namespace isosplat::cli
