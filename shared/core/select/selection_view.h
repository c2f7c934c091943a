#pragma once

#include <array>
#include <vector>

#include "shared/core/grid/grid.h"

namespace isosplat {

/// A camera view: what to show, and at what resolution.
struct SelectionView {
  /// World to clip space (projection · view), column-major as in OpenGL. Perspective or
  /// orthographic. Clip space is −w ≤ x, y, z ≤ w.
  std::array<double, 16> view_projection{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  double width_px = 1;
  double height_px = 1;
  std::vector<float> quantized_isovalues;  ///< the isosurfaces shown; if empty, nothing is selected

  /// A block whose cells are larger than this on the screen is refined.
  double load_cell_px = 1;

  /// A block whose cells are larger than this on the screen is replaced by finer blocks if all of
  /// them are resident, even if this view does not need them. While the camera moves, this is less
  /// than load_cell_px: chunks that were fetched are drawn, but no finer ones are requested.
  double draw_cell_px = 1;

  /// The refinement stops before the selected blocks have more cells than this.
  uint64_t cell_budget = UINT64_MAX;

  /// Excludes blocks that are hidden according to Selector::set_visibility, and blocks whose
  /// occlusion query is pending.
  bool occlusion = false;
};

/// Projects the blocks of a volume to the screen.
class ScreenProjection {
 public:
  ScreenProjection(const VolumeGrid& grid, const SelectionView& view);

  struct Footprint {
    bool outside = true;  ///< the block, with a margin of one cell, is outside the frustum
    double cell_px = 0;   ///< size of a cell at the block's nearest corner, along its longest axis
    double centre_distance = 0;  ///< of the block's centre from the screen's, in clip units
  };

  Footprint footprint(const LevelGrid& level, Index3 block) const;

 private:
  std::array<double, 16> clip_from_index_;  ///< column-major, from level-0 voxel units
  double px_per_unit_at_w1_ = 0;            ///< pixels per world unit where w = 1
  double longest_spacing_ = 0;
};

}  // namespace isosplat
