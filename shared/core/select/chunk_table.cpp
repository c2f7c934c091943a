#include "shared/core/select/chunk_table.h"

namespace isosplat {

ChunkHandle ChunkTable::handle_of(const ChunkRef& chunk) {
  // Quantized values have 16 bits, so a block has at most 65536 bands.
  const uint64_t key = block_id(chunk.block) << 16 | chunk.band;
  const auto [entry, added] = handles_.try_emplace(key, static_cast<ChunkHandle>(chunks_.size()));
  if (added) {
    chunks_.push_back(chunk);
    resident_.push_back(false);
  }
  return entry->second;
}

void ChunkTable::set_resident(ChunkHandle handle, bool resident) {
  if (resident_[handle] == resident) return;
  resident_[handle] = resident;
  BlockKey block = chunks_[handle].block;
  while (block.level < kMaxLevels) {
    ++block.level;
    block.index = {block.index.x / 2, block.index.y / 2, block.index.z / 2};
    const auto entry = resident_descendants_.try_emplace(block_id(block), 0).first;
    if (resident) {
      ++entry->second;
    } else if (--entry->second == 0) {
      resident_descendants_.erase(entry);
    }
  }
}

}  // namespace isosplat
