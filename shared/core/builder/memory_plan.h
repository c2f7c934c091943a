#pragma once

#include <vector>

#include "shared/core/base/status.h"
#include "shared/core/grid/volume_header.h"

namespace isosplat {

/// The memory of a build, planned before it starts. Levels are built one after the other: one layer
/// of blocks of the current level is in memory. The next coarser level is written meanwhile, to
/// memory if the limit allows it, else to a temporary file.
struct MemoryPlan {
  std::vector<bool> in_memory;  ///< per level; level 0 is read from the source, so false
  uint64_t bytes = 0;           ///< peak memory of this plan
  uint64_t min_bytes = 0;       ///< peak memory with as many levels in temporary files as possible
};

/// `source_bytes`: memory of the source. `encoders`: number of blocks that are encoded at the same
/// time. `limit`: the memory limit of the whole build, in bytes. Without temporary files, all
/// levels are in memory. Errors: out_of_memory if min_bytes exceeds the limit.
Result<MemoryPlan> plan_memory(const VolumeHeader& header, uint64_t source_bytes, unsigned encoders,
                               bool has_temporary_files, uint64_t limit);

}  // namespace isosplat
