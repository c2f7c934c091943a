#pragma once

#include <array>

#include "shared/core/grid/grid.h"

namespace isosplat::render {

/// A camera that orbits a target, perspective or orthographic. A URL stores these numbers, and the
/// command line takes them. World frame of the volume (LPS for medical images: x to the patient's
/// left, y to the back, z up). Angles in degrees.
struct Camera {
  Vec3d target;               ///< world: the point that the camera looks at, and orbits
  double distance = 1;        ///< from the eye to the target, world units, > 0
  double azimuth = 30;        ///< 0: the eye is in front (−y); 90: at the left (+x)
  double elevation = 20;      ///< −90 … 90; 90: the eye is above (+z)
  double roll = 0;            ///< about the viewing direction, clockwise as seen
  double field_of_view = 30;  ///< vertical, 1 … 120

  /// Rays are parallel, and the plane through the target is as large in the image as it is with
  /// perspective. Nothing is behind the eye: the whole volume is in front of the near plane.
  bool orthographic = false;

  friend constexpr bool operator==(const Camera&, const Camera&) = default;
};

/// The camera's axes and position in the world. The axes are orthonormal: right × up = −forward.
struct CameraFrame {
  Vec3d eye, right, up, forward;
  double tan_half_field_of_view = 1;

  /// World units from the middle of the image to its upper edge, at this distance along the view.
  double half_height(double distance) const {
    return (orthographic ? target_distance : distance) * tan_half_field_of_view;
  }
  double target_distance = 1;
  bool orthographic = false;
};

CameraFrame camera_frame(const Camera& camera);

/// The initial camera of a volume: from the front left, slightly above, at the smallest distance at
/// which the whole volume is in an image of this aspect ratio (width / height).
Camera default_camera(const VolumeGrid& grid, double aspect = 1, bool orthographic = false);

/// The bounding sphere of the volume, in world coordinates.
struct BoundingSphere {
  Vec3d centre;
  double radius = 0;
};
BoundingSphere bounding_sphere(const VolumeGrid& grid);

/// Orbits the eye around the target, as a pointer drags the volume: in degrees to the right and
/// upwards. The elevation stops at the poles.
Camera orbited(Camera camera, double right_degrees, double up_degrees);

/// Shifts target and eye in the image plane so that the target's plane follows a pointer that moves
/// by this number of pixels (y down) in an image of the given height.
Camera panned(Camera camera, double right_px, double down_px, double image_height_px);

/// Multiplies the distance by a factor; < 1 moves closer. The distance stays within [10⁻⁴, 10²]
/// times the volume's radius.
Camera zoomed(Camera camera, double factor, double volume_radius);

/// A valid camera from any numbers, such as those of a URL: limits the distance as zoomed(), and
/// the angles to their ranges. Returns default_camera() if a number is not finite or if the target
/// is more than 100 radii from the volume's centre. Returns a valid camera unchanged.
Camera bounded(const Camera& camera, const VolumeGrid& grid);

/// A 4×4 matrix, column by column, as OpenGL reads it.
using Matrix4d = std::array<double, 16>;

/// Transforms positions relative to `origin` (world) into clip space. Near and far plane enclose
/// the sphere tightly, for the best depth precision. With an orthographic camera, w is 1, and the
/// near plane can be behind the eye.
struct Projection {
  Matrix4d clip_from_world;              ///< of position − origin
  double near_plane = 0, far_plane = 0;  ///< distances along the view
};
Projection projection(const Camera& camera, BoundingSphere scene, Vec3d origin, int width,
                      int height);

}  // namespace isosplat::render
