#pragma once

#include <algorithm>
#include <vector>

#include "shared/core/base/status.h"
#include "shared/core/grid/volume_header.h"
#include "shared/core/preprocess/layer.h"

namespace isosplat {

/// The memory of a build, planned before it starts. Levels are built one after the other: one layer
/// of blocks of the current level is in memory, or one band of it if the limit does not allow a
/// layer. The next coarser level is written meanwhile, to memory if the limit allows it, else to a
/// temporary file.
struct MemoryPlan {
  std::vector<bool> in_memory;  ///< per level; level 0 is read from the source, so false
  /// Per level: rows of blocks of a band, the same in each layer; all rows if layers are whole.
  std::vector<int32_t> band_rows;
  uint64_t bytes = 0;      ///< peak memory of this plan
  uint64_t min_bytes = 0;  ///< peak memory with bands and temporary files wherever possible
};

/// `source_bytes`: memory of the source. `reads_rows`: as VolumeSource::reads_rows; if false,
/// layers of level 0 are whole. `encoders`: number of blocks that are encoded at the same time.
/// `limit`: the memory limit of the whole build, in bytes. Without temporary files, all levels are
/// in memory. Errors: out_of_memory if min_bytes exceeds the limit.
Result<MemoryPlan> plan_memory(const VolumeHeader& header, uint64_t source_bytes, bool reads_rows,
                               unsigned encoders, bool has_temporary_files, uint64_t limit);

/// The band of a level's layer that begins with a row of blocks: band_rows rows, or those that are
/// left.
inline BlockRows band_at(const LevelGrid& grid, int32_t first, int32_t band_rows) {
  return {first, std::min(first + band_rows, grid.blocks.y)};
}

}  // namespace isosplat
