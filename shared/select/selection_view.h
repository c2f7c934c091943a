#pragma once

#include <array>
#include <vector>

#include "shared/grid/grid.h"

namespace isosplat {

/// What is looked at, and how finely.
struct SelectionView {
  /// World to clip space (projection · view), column-major as OpenGL takes it. Perspective or
  /// orthographic. Clip space is −w ≤ x, y, z ≤ w.
  std::array<double, 16> view_projection{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  double width_px = 1;
  double height_px = 1;
  std::vector<float> quantized_isovalues;  ///< the isosurfaces shown

  /// A block whose cells are larger than this on the screen is refined.
  double load_cell_px = 1;

  /// A block whose cells are larger than this is drawn by finer blocks where all of them are
  /// resident, wanted or not. Smaller than load_cell_px while the camera moves: what has been
  /// fetched is shown, and nothing more is asked for.
  double draw_cell_px = 1;

  /// Most cells that the refinement may add up to.
  uint64_t cell_budget = UINT64_MAX;

  /// Asks only for what can be seen, as Selector::set_visibility tells it, and for nothing of which
  /// it has not been told yet but is about to be.
  bool occlusion = false;
};

/// Where blocks of a volume come to lie on the screen.
class ScreenProjection {
 public:
  ScreenProjection(const VolumeGrid& grid, const SelectionView& view);

  struct Footprint {
    bool outside = true;  ///< no part of the block, nor of a margin of one cell, is in the frustum
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
