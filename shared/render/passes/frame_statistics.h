#pragma once

#include <cstdint>

namespace isosplat::render {

/// Statistics of a draw.
struct FrameStatistics {
  /// Samples in drawn clusters (regions of 8³ cells), counted once for each isosurface.
  uint64_t samples_drawn = 0;
  uint64_t samples_resident = 0;
  uint64_t gpu_bytes = 0;  ///< buffers and targets that the renderer holds
  uint32_t chunks_drawn = 0;
  uint32_t chunks_culled = 0;  ///< of set_visible(), outside of the frustum or clip planes
  uint32_t draw_calls = 0;
  uint32_t programs_linked = 0;  ///< for the first time in this draw, which delays it
};

}  // namespace isosplat::render
