#pragma once

#include <array>
#include <vector>

#include "shared/render/frame/image_tile.h"
#include "shared/render/settings/camera.h"
#include "shared/render/settings/render_settings.h"
#include "shared/render/shaders/shader_constants.h"

namespace isosplat::render {

/// The uniform block of shaders/frame.glsl, laid out as std140; the members are explained there.
/// Its size is a multiple of 16 bytes: WebGL draws nothing with a smaller buffer than the block.
struct alignas(16) FrameBlock {
  using Vec2 = std::array<float, 2>;
  using Vec4 = std::array<float, 4>;

  Vec4 right, up, forward;
  Vec4 step_right, step_up, step_forward;
  Vec4 reach_of_unit;
  std::array<Vec4, 3> ascent;
  Vec4 cell_edges;
  std::array<Vec4, MAX_CLIP_PLANES> clip_plane;
  Vec2 depth_terms;
  float near_plane, far_plane;
  Vec2 image_size, guard_scale;
  Vec2 image_middle, tile_corner;
  float focal_px, per_focal_px;
  float largest_point_px;
  float splat_scale;
  float displacement_threshold;
  float log_distance_per_unit;
  int32_t clip_planes;
  int32_t projects, drops_far, orthographic;
};
static_assert(sizeof(FrameBlock) == 4 * ((11 + MAX_CLIP_PLANES) * 4 + 24));

/// The number of clip planes, and of faces of the clip box that cut the volume. They are the first
/// planes of the block; with caps, planes that bound the volume follow.
int cuts_of(const RenderSettings& settings);

/// The faces of the clip box that cut the volume, in the world. The clip box is a fraction of this
/// volume's extent. The normals are not of unit length.
std::vector<Plane> clip_box_faces(const VolumeGrid& grid, const RenderSettings& settings);

/// Length of a unit of frame space in the world: the smallest spacing.
double unit_of_frame_space(const VolumeGrid& grid);

/// The data that the frames of all volumes of a picture share.
struct SceneExtent {
  BoundingSphere sphere;        ///< of all volumes: near and far plane enclose it
  const VolumeGrid& clip_grid;  ///< the clip box is a fraction of its extent
};

/// The geometry of one volume in one frame. It is computed in double precision, and passed to the
/// GPU relative to the eye, so that distant origins and large volumes lose no precision near the
/// eye.
///
/// "Frame space": coordinates along the volume's axes, one unit = the smallest spacing, the eye at
/// the origin. Cells are boxes in it, even those of a sheared grid. Row vectors (right, up,
/// forward, planes) measure distances along a direction of the world. Lengths and angles need
/// FrameBlock::ascent and the steps.
class Frame {
 public:
  /// `camera`: shows the whole image, of which the tile is drawn. `offset`: displacement of splats
  /// in the image. Meshes are not moved.
  Frame(const VolumeGrid& grid, const SceneExtent& scene, const RenderSettings& settings,
        const Camera& camera, const ImageTile& tile, float guard_px, float max_point_px,
        ImageOffset offset = {});

  const FrameBlock& block() const { return block_; }
  bool clipped() const { return block_.clip_planes > 0; }
  bool orthographic() const { return camera_.orthographic; }

  /// One unit of frame space in world units.
  double unit() const { return unit_; }

  /// The box of a half-open range of cells of level 0, in frame space.
  struct Box {
    Vec3d centre, half;
  };
  Box box(Vec3d low_cell, Vec3d high_cell) const;

  /// The side of a cube with the volume of a cell of level 0, in units.
  double cell_side() const { return cell_side_; }

  /// Whether a part of the box may be inside the clip planes and the frustum of the tile, or of the
  /// whole image.
  bool may_see(const Box& box) const { return may_see(box, sides_); }
  bool may_see_in_image(const Box& box) const { return may_see(box, image_sides_); }

  /// The slices of the settings as planes of frame space, with the length of the normal 1 in the
  /// world. Those without a normal are left out.
  const std::vector<Plane>& slices() const { return slices_; }

  /// The faces of the volume, in frame space.
  Vec3d volume_low() const { return eye_ * -1.0; }
  Vec3d volume_high() const { return extent_ - eye_; }

  /// Whether a plane of frame space cuts the box or is no farther from it than `margin`, in units
  /// of dot(normal, p).
  static bool is_near(const Box& box, const Plane& plane, double margin);

  /// Whether a clip plane may cut the box.
  bool may_cut(const Box& box) const;

  /// Distance along the view of the box's nearest point.
  double nearest(const Box& box) const;

  /// Pixels per unit at this distance along the view, or at the near plane if that is farther.
  double px_per_unit(double distance) const;

  /// Transform a mesh (world, relative to the volume's centre) into clip space, and its normals
  /// into the camera's frame.
  std::array<float, 16> mesh_clip() const;
  std::array<float, 9> mesh_view() const;

 private:
  /// Planes of a frustum: dot(normal, p) ≥ offset. The normals need not be of unit length.
  using Sides = std::array<Plane, 5>;

  void set_clip_planes(const VolumeGrid& grid, const VolumeGrid& clip_grid,
                       const RenderSettings& settings);
  void set_slices(const VolumeGrid& grid, const RenderSettings& settings);
  Sides sides_of(const ImageTile& tile, double near_plane) const;
  bool may_see(const Box& box, const Sides& sides) const;
  Plane clip_plane(int index) const;

  FrameBlock block_{};
  double unit_ = 1;
  double cell_side_ = 1;
  Vec3d spacing_, extent_;      // of a cell and of the volume, in units
  Vec3d eye_;                   // relative to voxel (0, 0, 0), along the axes of frame space
  Vec3d right_, up_, forward_;  // row vectors
  CameraFrame camera_;
  Matrix4d mesh_clip_;
  std::vector<Plane> slices_;
  Sides sides_, image_sides_;
};

}  // namespace isosplat::render
