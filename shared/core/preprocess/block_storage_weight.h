#pragma once

#include <cstddef>
#include <cstdint>

#include "shared/core/bands/band_planner.h"

namespace isosplat {

/// The options for cutting one block into bands: those of the volume, with λ adapted to the level
/// and to the share of the block's cells that are ever active.
BandOptions block_options(const BandOptions& options, uint32_t level, size_t active_cells,
                          size_t cells);

}  // namespace isosplat
