#pragma once

#include <nlohmann/json.hpp>

#include "native/cli/chunk_report.h"

namespace isosplat::cli {

/// The member `chunkReport` of `isosplat info --chunks --json`.
nlohmann::ordered_json chunks_json(const ChunkReport& chunks);

/// Prints two tables: the chunks of each level, and what isovalues need.
void print_chunks(const ChunkReport& chunks);

}  // namespace isosplat::cli
