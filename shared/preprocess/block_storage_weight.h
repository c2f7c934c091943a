#pragma once

#include <cstddef>
#include <cstdint>

#include "shared/bands/band_planner.h"

namespace isosplat {

/// The options with which one block is cut, from those of the whole volume: λ depends on the level,
/// and on how many of the block's cells are ever active.
BandOptions block_options(const BandOptions& options, uint32_t level, size_t active_cells,
                          size_t cells);

}  // namespace isosplat
