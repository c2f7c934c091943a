#pragma once

#include <cstddef>
#include <cstdint>

#include "shared/slabs/slab_planner.h"

namespace isosplat {

/// The options with which one block is cut, from those of the whole volume: λ depends on the level,
/// and on how many of the block's cells are ever active.
SlabOptions block_options(const SlabOptions& options, uint32_t level, size_t active_cells,
                          size_t cells);

}  // namespace isosplat
