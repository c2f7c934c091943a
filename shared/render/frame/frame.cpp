#include "shared/render/frame/frame.h"

#include <algorithm>
#include <cmath>

#include "shared/render/shaders/shader_constants.h"

namespace isosplat::render {
namespace {

std::array<float, 4> floats(Vec3d v, double w) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z),
          static_cast<float>(w)};
}

std::array<float, 2> floats(double x, double y) {
  return {static_cast<float>(x), static_cast<float>(y)};
}

double reach(Vec3d normal, Vec3d half) {
  return std::abs(normal.x) * half.x + std::abs(normal.y) * half.y + std::abs(normal.z) * half.z;
}

/// Turns the camera around its eye, so that the image moves by this offset in px. For fractions of
/// a pixel this equals a displacement of the image, and shaders need no change. An orthographic eye
/// moves instead.
CameraFrame turned(const CameraFrame& camera, ImageOffset offset, double focal_px) {
  CameraFrame to = camera;
  if (camera.orthographic) {
    to.eye =
        camera.eye - camera.right * (offset.right / focal_px) - camera.up * (offset.up / focal_px);
    return to;
  }
  const auto unit = [](Vec3d v) { return v * (1 / length(v)); };
  to.forward = unit(camera.forward - camera.right * (offset.right / focal_px) -
                    camera.up * (offset.up / focal_px));
  to.right = unit(camera.right - to.forward * dot(camera.right, to.forward));
  to.up = cross(to.right, to.forward);
  return to;
}

/// Clip space of the whole image to that of the tile.
Matrix4d clip_of_tile(Matrix4d clip, const ImageTile& tile) {
  const double across = double(tile.image_width) / tile.width;
  const double up = double(tile.image_height) / tile.height;
  const double to_right = across - 2.0 * tile.left / tile.width - 1;
  const double to_top = up - 2.0 * tile.bottom / tile.height - 1;
  for (size_t column = 0; column < 16; column += 4) {
    clip[column] = across * clip[column] + to_right * clip[column + 3];
    clip[column + 1] = up * clip[column + 1] + to_top * clip[column + 3];
  }
  return clip;
}

}  // namespace

double unit_of_frame_space(const VolumeGrid& grid) {
  return std::min({grid.spacing.x, grid.spacing.y, grid.spacing.z});
}

std::vector<Plane> clip_box_faces(const VolumeGrid& grid, const RenderSettings& settings) {
  // A voxel's coordinate along an axis is dot(column of dual, world − origin).
  const Matrix3d dual = grid.dual_edges();
  const Vec3d low = settings.clip_box_low, high = settings.clip_box_high;
  std::vector<Plane> faces;
  const auto add_axis = [&](size_t axis, double from, double to, int32_t voxels) {
    const Vec3d along = column(dual, axis);
    const double origin = dot(along, grid.origin), extent = voxels - 1;
    if (from > 0) faces.push_back({along, origin + from * extent});
    if (to < 1) faces.push_back({along * -1.0, -(origin + to * extent)});
  };
  add_axis(0, low.x, high.x, grid.voxels.x);
  add_axis(1, low.y, high.y, grid.voxels.y);
  add_axis(2, low.z, high.z, grid.voxels.z);
  return faces;
}

int cuts_of(const RenderSettings& settings) {
  const auto faces = [](double low, double high) { return (low > 0 ? 1 : 0) + (high < 1 ? 1 : 0); };
  const Vec3d low = settings.clip_box_low, high = settings.clip_box_high;
  return static_cast<int>(std::min<size_t>(settings.clip_planes.size(), kMaxClipPlanes)) +
         faces(low.x, high.x) + faces(low.y, high.y) + faces(low.z, high.z);
}

Frame::Frame(const VolumeGrid& grid, const SceneExtent& scene, const RenderSettings& settings,
             const Camera& camera, const ImageTile& tile, float guard_px, float max_point_px,
             ImageOffset offset)
    : camera_(camera_frame(camera)) {
  unit_ = unit_of_frame_space(grid);
  // Pixels per radian at the middle of the image; orthographic: per unit.
  const double world_px = 0.5 * tile.image_height / camera_.half_height(1);
  const double focal_px = camera.orthographic ? world_px * unit_ : world_px;
  camera_ = turned(camera_, offset, world_px);
  spacing_ = grid.spacing * (1 / unit_);
  extent_ = {(grid.voxels.x - 1) * spacing_.x, (grid.voxels.y - 1) * spacing_.y,
             (grid.voxels.z - 1) * spacing_.z};
  const Projection to_clip = projection(camera, scene.sphere, bounding_sphere(grid).centre,
                                        tile.image_width, tile.image_height);
  mesh_clip_ = clip_of_tile(to_clip.clip_from_world, tile);

  // p along the axes is direction · p in the world. So dot(v, direction · p) = dot(row(v), p), and
  // a step v of the world is along(v). The two differ where the axes are not perpendicular.
  const Matrix3d dual = inverse_transpose(grid.direction);
  const auto row = [&](Vec3d v) { return multiply_transposed(grid.direction, v); };
  const auto along = [&](Vec3d v) { return multiply_transposed(dual, v); };
  right_ = row(camera_.right);
  up_ = row(camera_.up);
  forward_ = row(camera_.forward);
  eye_ = along(camera_.eye - grid.origin) * (1 / unit_);
  cell_side_ =
      std::cbrt(spacing_.x * spacing_.y * spacing_.z * std::abs(determinant(grid.direction)));

  const double near_plane = to_clip.near_plane / unit_, far_plane = to_clip.far_plane / unit_;
  // Extent of a sphere of radius 1 along each axis: the lengths of the rows of the inverse.
  const Vec3d reach{length(column(dual, 0)), length(column(dual, 1)), length(column(dual, 2))};
  block_.right = floats(right_, 0);
  block_.up = floats(up_, 0);
  block_.forward = floats(forward_, 0);
  block_.step_right = floats(along(camera_.right), 0);
  block_.step_up = floats(along(camera_.up), 0);
  block_.step_forward = floats(along(camera_.forward), 0);
  block_.reach_of_unit = floats(reach, 0);
  for (size_t axis = 0; axis < 3; ++axis) {
    block_.ascent[axis] = floats(multiply_transposed(dual, column(dual, axis)), 0);
  }
  const double middle = far_plane + near_plane, range = far_plane - near_plane;
  block_.depth_terms = camera.orthographic
                           ? floats(-middle / range, 2 / range)
                           : floats(middle / range, -2 * far_plane * near_plane / range);
  block_.near_plane = static_cast<float>(near_plane);
  block_.far_plane = static_cast<float>(far_plane);
  const double width = tile.width, height = tile.height;
  block_.image_size = floats(width, height);
  block_.guard_scale = floats(width / (width + 2.0 * guard_px), height / (height + 2.0 * guard_px));
  block_.image_middle =
      floats(0.5 * tile.image_width - tile.left, 0.5 * tile.image_height - tile.bottom);
  block_.tile_corner = floats(tile.left, tile.bottom);
  block_.focal_px = static_cast<float>(focal_px);
  block_.per_focal_px = static_cast<float>(1 / focal_px);
  block_.largest_point_px = max_point_px;
  block_.splat_scale = settings.splat_scale;
  block_.cell_edges = floats(spacing_, 0);
  block_.displacement_threshold =
      static_cast<float>(displacement_threshold(grid.cell_edges()) / unit_);
  // Edge shading compares logarithms of distances.
  block_.log_distance_per_unit = static_cast<float>(unit_ / (std::log(2.0) * camera.distance));

  set_clip_planes(grid, scene.clip_grid, settings);
  set_slices(grid, settings);
  block_.projects = settings.projected ? 1 : 0;
  block_.drops_far = settings.displaced == Displaced::drop ? 1 : 0;
  block_.orthographic = camera.orthographic ? 1 : 0;
  sides_ = sides_of(tile, near_plane);
  const ImageTile image{tile.image_width, tile.image_height};
  image_sides_ = tile == image ? sides_ : sides_of(image, near_plane);
}

Frame::Sides Frame::sides_of(const ImageTile& tile, double near_plane) const {
  const double px = 1 / double(block_.focal_px);
  const double left = px * (tile.left - 0.5 * tile.image_width), right = left + px * tile.width;
  const double low = px * (tile.bottom - 0.5 * tile.image_height), high = low + px * tile.height;
  const auto side = [this](Vec3d normal, double offset) {
    // The offset of an orthographic camera is a distance from the middle of the image; that of a
    // perspective one is multiplied by the distance along the view.
    const Vec3d n = orthographic() ? normal : normal - forward_ * offset;
    return Plane{n, orthographic() ? offset : 0};
  };
  return {side(right_, left), side(right_ * -1.0, -right), side(up_, low), side(up_ * -1.0, -high),
          Plane{forward_, near_plane}};
}

/// The planes of the settings, and those of the clip box that cut its volume; with caps, then those
/// of this volume's border. These are moved out by less than the margin of splats, so that surfaces
/// on the border are not lost by rounding.
void Frame::set_clip_planes(const VolumeGrid& grid, const VolumeGrid& clip_grid,
                            const RenderSettings& settings) {
  int planes = 0;
  const auto add = [&](Vec3d normal, double offset) {
    if (planes < MAX_CLIP_PLANES) {
      block_.clip_plane[static_cast<size_t>(planes++)] = floats(normal, offset);
    }
  };
  for (size_t i = 0; i < settings.clip_planes.size() && i < kMaxClipPlanes; ++i) {
    const Plane& plane = settings.clip_planes[i];
    add(multiply_transposed(grid.direction, plane.normal),
        (plane.offset - dot(plane.normal, camera_.eye)) / unit_);
  }
  // If the clip box is a fraction of this volume's extent, its faces replace those of the border.
  Vec3d low = settings.clip_box_low, high = settings.clip_box_high;
  if (&grid == &clip_grid) {
    if (low.x > 0) add({1, 0, 0}, low.x * extent_.x - eye_.x);
    if (low.y > 0) add({0, 1, 0}, low.y * extent_.y - eye_.y);
    if (low.z > 0) add({0, 0, 1}, low.z * extent_.z - eye_.z);
    if (high.x < 1) add({-1, 0, 0}, eye_.x - high.x * extent_.x);
    if (high.y < 1) add({0, -1, 0}, eye_.y - high.y * extent_.y);
    if (high.z < 1) add({0, 0, -1}, eye_.z - high.z * extent_.z);
  } else {
    for (const Plane& face : clip_box_faces(clip_grid, settings)) {
      add(multiply_transposed(grid.direction, face.normal),
          (face.offset - dot(face.normal, camera_.eye)) / unit_);
    }
    low = {0, 0, 0};
    high = {1, 1, 1};
  }
  if (settings.clip_caps && planes > 0) {
    const Vec3d margin = spacing_ * (0.5 * double(EXACT_MARGIN_CELLS));
    if (!(low.x > 0)) add({1, 0, 0}, -margin.x - eye_.x);
    if (!(low.y > 0)) add({0, 1, 0}, -margin.y - eye_.y);
    if (!(low.z > 0)) add({0, 0, 1}, -margin.z - eye_.z);
    if (!(high.x < 1)) add({-1, 0, 0}, eye_.x - extent_.x - margin.x);
    if (!(high.y < 1)) add({0, -1, 0}, eye_.y - extent_.y - margin.y);
    if (!(high.z < 1)) add({0, 0, -1}, eye_.z - extent_.z - margin.z);
  }
  block_.clip_planes = planes;
}

void Frame::set_slices(const VolumeGrid& grid, const RenderSettings& settings) {
  for (size_t i = 0; i < settings.slices.size() && i < kMaxSlices; ++i) {
    const auto slice = unit_plane(settings.slices[i]);
    if (!slice) continue;
    slices_.push_back({multiply_transposed(grid.direction, slice->normal),
                       (slice->offset - dot(slice->normal, camera_.eye)) / unit_});
  }
}

Plane Frame::clip_plane(int index) const {
  const auto& p = block_.clip_plane[static_cast<size_t>(index)];
  return {{double(p[0]), double(p[1]), double(p[2])}, double(p[3])};
}

Frame::Box Frame::box(Vec3d low_cell, Vec3d high_cell) const {
  const Vec3d half = (high_cell - low_cell) * 0.5, centre = (high_cell + low_cell) * 0.5;
  return {Vec3d{centre.x * spacing_.x, centre.y * spacing_.y, centre.z * spacing_.z} - eye_,
          {half.x * spacing_.x, half.y * spacing_.y, half.z * spacing_.z}};
}

bool Frame::may_see(const Box& box, const Sides& sides) const {
  const auto is_behind = [&](const Plane& plane) {
    return dot(plane.normal, box.centre) + reach(plane.normal, box.half) < plane.offset;
  };
  if (std::any_of(sides.begin(), sides.end(), is_behind)) return false;
  for (int i = 0; i < block_.clip_planes; ++i) {
    if (is_behind(clip_plane(i))) return false;
  }
  return true;
}

bool Frame::is_near(const Box& box, const Plane& plane, double margin) {
  return std::abs(dot(plane.normal, box.centre) - plane.offset) <=
         reach(plane.normal, box.half) + margin;
}

bool Frame::may_cut(const Box& box) const {
  constexpr double kRounding = 1e-2;  // units; planes are in single precision
  for (int i = 0; i < block_.clip_planes; ++i) {
    if (is_near(box, clip_plane(i), kRounding)) return true;
  }
  return false;
}

double Frame::nearest(const Box& box) const {
  return dot(forward_, box.centre) - reach(forward_, box.half);
}

double Frame::px_per_unit(double distance) const {
  const double focal_px = double(block_.focal_px), near_plane = double(block_.near_plane);
  return orthographic() ? focal_px : focal_px / std::max(distance, near_plane);
}

std::array<float, 16> Frame::mesh_clip() const {
  std::array<float, 16> result;
  for (size_t i = 0; i < 16; ++i) result[i] = static_cast<float>(mesh_clip_[i]);
  return result;
}

std::array<float, 9> Frame::mesh_view() const {
  const Vec3d r = camera_.right, u = camera_.up, f = camera_.forward;
  return {static_cast<float>(r.x), static_cast<float>(u.x), static_cast<float>(-f.x),
          static_cast<float>(r.y), static_cast<float>(u.y), static_cast<float>(-f.y),
          static_cast<float>(r.z), static_cast<float>(u.z), static_cast<float>(-f.z)};
}

}  // namespace isosplat::render
