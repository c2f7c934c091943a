#include "native/cli/chunk_report_text.h"

#include <fmt/format.h>

namespace isosplat::cli {

nlohmann::ordered_json chunks_json(const ChunkReport& chunks) {
  using Json = nlohmann::ordered_json;
  Json levels = Json::array(), queries = Json::array();
  for (const auto& level : chunks.levels) {
    levels.push_back({{"blocks", level.blocks},
                      {"emptyBlocks", level.empty_blocks},
                      {"chunks", level.chunks},
                      {"bytes", level.bytes},
                      {"cells", level.cells},
                      {"chunkBytes", level.chunk_bytes},
                      {"blockBands", level.block_bands}});
  }
  for (const auto& query : chunks.queries) {
    queries.push_back({{"isovalue", query.isovalue},
                       {"chunks", query.chunks},
                       {"bytes", query.bytes},
                       {"fetchedCells", query.fetched_cells},
                       {"activeCells", query.active_cells}});
    for (size_t i = 0; i < chunks.fields.size(); ++i) {
      queries.back()["fieldBytes"][chunks.fields[i]] = query.field_bytes[i];
    }
  }
  return {{"quantiles", ChunkReport::kQuantiles},
          {"levels", std::move(levels)},
          {"queries", std::move(queries)}};
}

void print_chunks(const ChunkReport& chunks) {
  fmt::print("\nchunks by level (sizes in bytes at the quantiles 0, 5, 25, 50, 75, 95, 100 %)\n");
  fmt::print("  {:>5} {:>8} {:>8} {:>12} {:>12}  {:<44} bands per block\n", "level", "blocks",
             "chunks", "bytes", "bytes/cell", "chunk size");
  for (size_t i = 0; i < chunks.levels.size(); ++i) {
    const auto& level = chunks.levels[i];
    std::string sizes, bands;
    for (const uint32_t size : level.chunk_bytes) sizes += fmt::format("{} ", size);
    for (const uint32_t count : level.block_bands) bands += fmt::format("{} ", count);
    fmt::print(
        "  {:>5} {:>8} {:>8} {:>12} {:>12.2f}  {:<44} {}\n", i, level.blocks, level.chunks,
        level.bytes,
        level.cells > 0 ? static_cast<double>(level.bytes) / static_cast<double>(level.cells) : 0.0,
        sizes, bands);
  }
  fmt::print("\nlevel 0 at some isovalues\n  {:>12} {:>8} {:>12} {:>14} {:>14} {:>10}\n",
             "isovalue", "chunks", "bytes", "cells fetched", "active cells", "ratio");
  for (const auto& query : chunks.queries) {
    fmt::print("  {:>12.6g} {:>8} {:>12} {:>14} {:>14} {:>10.2f}\n", query.isovalue, query.chunks,
               query.bytes, query.fetched_cells, query.active_cells,
               query.active_cells > 0 ? static_cast<double>(query.fetched_cells) /
                                            static_cast<double>(query.active_cells)
                                      : 0.0);
  }
  for (size_t i = 0; i < chunks.fields.size(); ++i) {
    fmt::print("\nfield {} at these isovalues\n  {:>12} {:>12} {:>18}\n", chunks.fields[i],
               "isovalue", "bytes", "bytes/active cell");
    for (const auto& query : chunks.queries) {
      if (query.active_cells == 0) continue;
      fmt::print(
          "  {:>12.6g} {:>12} {:>18.2f}\n", query.isovalue, query.field_bytes[i],
          static_cast<double>(query.field_bytes[i]) / static_cast<double>(query.active_cells));
    }
  }
}

}  // namespace isosplat::cli
