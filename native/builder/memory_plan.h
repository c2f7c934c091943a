#pragma once

#include <vector>

#include "native/builder/builder.h"

namespace isosplat {

/// What a build will hold at a time, settled before it starts. Levels are built one after the
/// other: a layer of blocks of one level is in memory, and the next coarser level grows, in memory
/// where the allowance has room for it, else in a temporary file.
struct MemoryPlan {
  std::vector<bool> in_memory;  ///< per level; level 0 is read from the source, so false
  uint64_t bytes = 0;           ///< the most that is held at any time
  uint64_t min_bytes = 0;       ///< the same, were every level in a temporary file
};

/// Errors: out_of_memory where min_bytes exceeds the allowance.
Result<MemoryPlan> plan_memory(const VolumeHeader& header, uint64_t source_bytes, unsigned threads,
                               uint64_t allowance);

}  // namespace isosplat
