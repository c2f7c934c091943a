#pragma once

#include <array>

#include "shared/render/accumulation.h"
#include "shared/render/renderer.h"

namespace isosplat {

/// The uniform block of shaders/frame.glsl, laid out as std140.
struct FrameBlock {
  std::array<float, 4> right, up, forward;
  std::array<float, 4> step_right, step_up, step_forward;
  std::array<std::array<float, 4>, 3> ascent;
  std::array<float, 4> depth;
  std::array<float, 4> image;
  std::array<float, 4> lens;
  std::array<float, 4> cell;
  std::array<std::array<float, 4>, 12> clip_plane;
  std::array<int32_t, 4> switches;
};
static_assert(sizeof(FrameBlock) == 4 * (13 * 4 + 12 * 4 + 4));

/// The geometry of one frame, computed in double precision and handed to the GPU relative to the
/// eye, so that far-off origins and large volumes cost no precision where it is seen.
///
/// "Frame space": coordinates along the volume's axes, one unit = the smallest spacing, the eye at
/// the origin. Cells are boxes there, also of a sheared grid: what is measured along a direction of
/// the world is measured with a row vector (right, up, forward, planes), and what is true of
/// lengths and angles with FrameBlock::ascent and the steps.
class Frame {
 public:
  /// `offset`: by how much splats are moved in the image; meshes stay.
  Frame(const VolumeGrid& grid, const RenderSettings& settings, const Camera& camera, int width,
        int height, float guard_px, float max_point_px, ImageOffset offset = {});

  const FrameBlock& block() const { return block_; }
  bool clipped() const { return block_.switches[0] > 0; }

  /// One unit of frame space in world units.
  double unit() const { return unit_; }

  /// A box of cells of level 0, half open, in frame space.
  struct Box {
    Vec3d centre, half;
  };
  Box box(Vec3d low_cell, Vec3d high_cell) const;

  /// The length of the side of a cube as large as a cell of level 0, in units.
  double cell_side() const { return cell_side_; }

  /// Whether a part of the box may be seen: inside the frustum and the clip planes.
  bool may_see(const Box& box) const;

  /// Distance along the view of the box's nearest point.
  double nearest(const Box& box) const;

  /// A mesh's vertices (world, relative to the volume's centre) to clip space and to the view.
  std::array<float, 16> mesh_clip() const;
  std::array<float, 9> mesh_view() const;

 private:
  FrameBlock block_{};
  double unit_ = 1;
  double cell_side_ = 1;
  Vec3d spacing_;               // in units
  Vec3d eye_;                   // from the volume's voxel (0, 0, 0), frame space axes
  Vec3d right_, up_, forward_;  // row vectors
  CameraFrame camera_;
  Matrix4d mesh_clip_;
  std::array<std::array<double, 4>, 5> sides_;  // frustum: dot(xyz, p) ≥ w
};

}  // namespace isosplat
