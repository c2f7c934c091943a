#pragma once

#include <unordered_map>
#include <vector>

#include "shared/core/select/block_id.h"
#include "shared/core/select/selector.h"

namespace isosplat {

/// All chunks that have a handle, and which of them are resident.
class ChunkTable {
 public:
  ChunkHandle handle_of(const ChunkRef& chunk);

  bool contains(ChunkHandle handle) const { return handle < chunks_.size(); }
  const ChunkRef& chunk(ChunkHandle handle) const { return chunks_[handle]; }
  bool is_resident(ChunkHandle handle) const { return resident_[handle]; }
  void set_resident(ChunkHandle handle, bool resident);

  /// Whether a chunk of a finer block that lies within this block is resident.
  bool has_resident_descendant(BlockKey block) const {
    return resident_descendants_.contains(block_id(block));
  }

 private:
  std::vector<ChunkRef> chunks_;
  std::vector<bool> resident_;
  std::unordered_map<uint64_t, ChunkHandle> handles_;  ///< by packed block and band
  std::unordered_map<uint64_t, uint32_t>
      resident_descendants_;  ///< resident chunks of finer blocks, if any
};

}  // namespace isosplat
