#include "shared/bindings/wasm/core_state.h"

#include <utility>

namespace isosplat::wasm {

IsosplatStatus report(IsosplatCore* core, const Error& error) {
  core->error = error.message;
  return static_cast<IsosplatStatus>(error.status);
}

IsosplatStatus report(IsosplatCore* core, Status status, std::string message) {
  return report(core, Error{status, std::move(message)});
}

IsosplatStatus no_store(IsosplatCore* core) {
  return report(core, Status::invalid_argument, "no store is open: call open first");
}

Index3 as_index(const uint32_t* words) {
  return {static_cast<int32_t>(words[0]), static_cast<int32_t>(words[1]),
          static_cast<int32_t>(words[2])};
}

void copy_index(const Index3& index, uint32_t* words) {
  words[0] = static_cast<uint32_t>(index.x);
  words[1] = static_cast<uint32_t>(index.y);
  words[2] = static_cast<uint32_t>(index.z);
}

IsosplatChunk chunk_record(IsosplatCore* core, const ChunkRef& chunk) {
  IsosplatChunk result{};
  result.offset = static_cast<double>(chunk.offset);
  result.handle = core->selector->handle_of(chunk);
  result.level = chunk.block.level;
  copy_index(chunk.block.index, result.block);
  result.band = chunk.band;
  result.band_begin = chunk.band_begin;
  result.band_end = chunk.band_end;
  result.bytes = chunk.bytes;
  result.cells = chunk.cells;
  result.checksum = chunk.checksum;
  copy_index(block_cells(core->store->levels()[chunk.block.level].grid, chunk.block.index),
             result.block_cells);
  return result;
}

}  // namespace isosplat::wasm
