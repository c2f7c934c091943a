#include "shared/render/settings/camera.h"

#include <algorithm>
#include <cmath>

namespace isosplat::render {
namespace {

constexpr double kDegree = 3.14159265358979323846 / 180;

/// Limits of the distance from the eye to the target, in radii of the volume.
constexpr double kNearestRadii = 1e-4, kFarthestRadii = 1e2;

}  // namespace

CameraFrame camera_frame(const Camera& camera) {
  const double azimuth = camera.azimuth * kDegree, elevation = camera.elevation * kDegree;
  const Vec3d back{std::sin(azimuth) * std::cos(elevation),
                   -std::cos(azimuth) * std::cos(elevation), std::sin(elevation)};
  // Right does not depend on the elevation, so that the view is defined at the poles as well.
  const Vec3d level_right{std::cos(azimuth), std::sin(azimuth), 0};
  const Vec3d level_up = cross(back, level_right);
  const double c = std::cos(camera.roll * kDegree), s = std::sin(camera.roll * kDegree);
  return {camera.target + back * camera.distance,
          level_right * c + level_up * s,
          level_up * c - level_right * s,
          back * -1.0,
          std::tan(std::clamp(camera.field_of_view, 1.0, 120.0) / 2 * kDegree),
          camera.distance,
          camera.orthographic};
}

BoundingSphere bounding_sphere(const VolumeGrid& grid) {
  const Vec3d last{grid.voxels.x - 1.0, grid.voxels.y - 1.0, grid.voxels.z - 1.0};
  return {grid.world(last * 0.5), 0.5 * longest_diagonal(scale_columns(grid.cell_edges(), last))};
}

Camera default_camera(const VolumeGrid& grid, double aspect, bool orthographic) {
  Camera camera;
  camera.orthographic = orthographic;
  camera.target = bounding_sphere(grid).centre;
  const CameraFrame frame = camera_frame(camera);
  double distance = 0;
  for (int i = 0; i < 8; ++i) {
    const Vec3d corner =
        grid.world({i & 1 ? grid.voxels.x - 1.0 : 0.0, i & 2 ? grid.voxels.y - 1.0 : 0.0,
                    i & 4 ? grid.voxels.z - 1.0 : 0.0}) -
        camera.target;
    const double aside = std::max(std::abs(dot(corner, frame.right)) / std::max(aspect, 1e-3),
                                  std::abs(dot(corner, frame.up)));
    const double nearer = orthographic ? 0 : dot(corner, frame.forward);
    distance = std::max(distance, aside / frame.tan_half_field_of_view - nearer);
  }
  constexpr double kMargin = 1.04;
  if (distance > 0) camera.distance = kMargin * distance;
  return camera;
}

Camera orbited(Camera camera, double right_degrees, double up_degrees) {
  camera.azimuth = std::remainder(camera.azimuth - right_degrees, 360.0);
  camera.elevation = std::clamp(camera.elevation + up_degrees, -90.0, 90.0);
  return camera;
}

Camera panned(Camera camera, double right_px, double down_px, double image_height_px) {
  const CameraFrame frame = camera_frame(camera);
  const double world_per_px =
      2 * camera.distance * frame.tan_half_field_of_view / std::max(image_height_px, 1.0);
  camera.target =
      camera.target - frame.right * (right_px * world_per_px) + frame.up * (down_px * world_per_px);
  return camera;
}

Camera zoomed(Camera camera, double factor, double volume_radius) {
  camera.distance = std::clamp(camera.distance * factor, kNearestRadii * volume_radius,
                               kFarthestRadii * volume_radius);
  return camera;
}

Camera bounded(const Camera& camera, const VolumeGrid& grid) {
  for (const double number :
       {camera.target.x, camera.target.y, camera.target.z, camera.distance, camera.azimuth,
        camera.elevation, camera.roll, camera.field_of_view}) {
    if (!std::isfinite(number)) return default_camera(grid, 1, camera.orthographic);
  }
  const BoundingSphere volume = bounding_sphere(grid);
  if (length(camera.target - volume.centre) > kFarthestRadii * volume.radius) {
    return default_camera(grid, 1, camera.orthographic);
  }
  Camera result = zoomed(camera, 1, volume.radius);
  for (double Camera::*angle : {&Camera::azimuth, &Camera::roll}) {
    if (std::abs(camera.*angle) > 360) result.*angle = std::remainder(camera.*angle, 360.0);
  }
  result.elevation = std::clamp(camera.elevation, -90.0, 90.0);
  result.field_of_view = std::clamp(camera.field_of_view, 1.0, 120.0);
  return result;
}

Projection projection(const Camera& camera, BoundingSphere scene, Vec3d origin, int width,
                      int height) {
  const CameraFrame frame = camera_frame(camera);
  const double centre_depth = dot(scene.centre - frame.eye, frame.forward);
  const double radius = 1.01 * scene.radius;  // coarse cells can reach beyond the volume
  const Vec3d from_eye = origin - frame.eye;
  if (camera.orthographic) {
    const double near_plane = centre_depth - radius, far_plane = centre_depth + radius;
    const double sy = 1 / frame.half_height(0), sx = sy * height / width, a = 1 / radius;
    const Vec3d r = frame.right * sx, u = frame.up * sy, f = frame.forward * a;
    return {{r.x, u.x, f.x, 0,  //
             r.y, u.y, f.y, 0,  //
             r.z, u.z, f.z, 0,  //
             dot(r, from_eye), dot(u, from_eye), dot(f, from_eye) - a * centre_depth, 1},
            near_plane,
            far_plane};
  }
  const double far_plane = std::max(centre_depth + radius, 1e-3 * radius);
  // Depth has no precision if the near plane is at the eye.
  const double near_plane = std::max(centre_depth - radius, 5e-4 * far_plane);
  const double sy = 1 / frame.tan_half_field_of_view, sx = sy * height / width;
  const double a = (far_plane + near_plane) / (far_plane - near_plane);
  const double b = -2 * far_plane * near_plane / (far_plane - near_plane);
  const Vec3d r = frame.right * sx, u = frame.up * sy, f = frame.forward;
  return {{r.x, u.x, a * f.x, f.x,  //
           r.y, u.y, a * f.y, f.y,  //
           r.z, u.z, a * f.z, f.z,  //
           dot(r, from_eye), dot(u, from_eye), a * dot(f, from_eye) + b, dot(f, from_eye)},
          near_plane,
          far_plane};
}

}  // namespace isosplat::render
