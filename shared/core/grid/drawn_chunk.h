#pragma once

#include <cstdint>

#include "shared/core/grid/region_mask.h"

namespace isosplat {

/// A small number that identifies a chunk, as Selector::handle_of assigns it.
using ChunkHandle = uint32_t;

/// A chunk to draw, in these regions of its block. Finer chunks are drawn in the other regions.
struct DrawnChunk {
  ChunkHandle handle = 0;
  RegionMask regions = RegionMask::all();

  friend bool operator==(const DrawnChunk&, const DrawnChunk&) = default;
};

/// The result of an occlusion query for a drawn chunk.
struct ChunkVisibility {
  ChunkHandle handle = 0;
  RegionMask tested;   ///< the regions that were drawn
  RegionMask visible;  ///< those of them that may be visible
};

}  // namespace isosplat
