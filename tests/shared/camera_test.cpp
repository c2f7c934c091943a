#include "shared/render/settings/camera.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace isosplat::render {
namespace {

VolumeGrid grid() {
  VolumeGrid g;
  g.voxels = {65, 33, 17};
  g.spacing = {1, 2, 4};
  g.origin = {1000, -2000, 300};
  return g;
}

Vec3d transformed(const Matrix4d& m, Vec3d p) {
  const double w = m[3] * p.x + m[7] * p.y + m[11] * p.z + m[15];
  return {(m[0] * p.x + m[4] * p.y + m[8] * p.z + m[12]) / w,
          (m[1] * p.x + m[5] * p.y + m[9] * p.z + m[13]) / w,
          (m[2] * p.x + m[6] * p.y + m[10] * p.z + m[14]) / w};
}

TEST(Camera, LooksFromTheFrontAtAzimuthZero) {
  Camera camera;
  camera.azimuth = camera.elevation = 0;
  camera.distance = 5;
  const CameraFrame frame = camera_frame(camera);
  EXPECT_NEAR(frame.eye.y, -5, 1e-12);
  EXPECT_NEAR(frame.right.x, 1, 1e-12);
  EXPECT_NEAR(frame.up.z, 1, 1e-12);
}

TEST(Camera, DefaultShowsTheWholeVolumeWithinTheDepthRange) {
  const VolumeGrid g = grid();
  const Camera camera = default_camera(g);
  const BoundingSphere sphere = bounding_sphere(g);
  const Projection p = projection(camera, sphere, sphere.centre, 640, 480);
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3d at =
        g.world({corner & 1 ? 64.0 : 0.0, corner & 2 ? 32.0 : 0.0, corner & 4 ? 16.0 : 0.0}) -
        sphere.centre;
    const Vec3d ndc = transformed(p.clip_from_world, at);
    EXPECT_LT(std::abs(ndc.x), 1) << corner;
    EXPECT_LT(std::abs(ndc.y), 1) << corner;
    EXPECT_LE(std::abs(ndc.z), 1) << corner;
  }
}

TEST(Camera, OrthographicShowsTheWholeVolumeWithinTheDepthRange) {
  const VolumeGrid g = grid();
  Camera camera = default_camera(g, 640.0 / 480, /*orthographic=*/true);
  const BoundingSphere sphere = bounding_sphere(g);
  for (const double distance : {1.0, 1e-3}) {
    Camera nearer = camera;
    nearer.distance *= distance;
    const Projection p = projection(nearer, sphere, sphere.centre, 640, 480);
    double widest = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3d at =
          g.world({corner & 1 ? 64.0 : 0.0, corner & 2 ? 32.0 : 0.0, corner & 4 ? 16.0 : 0.0}) -
          sphere.centre;
      const Vec3d ndc = transformed(p.clip_from_world, at);
      widest = std::max({widest, std::abs(ndc.x) * distance, std::abs(ndc.y) * distance});
      EXPECT_LE(std::abs(ndc.z), 1) << corner;
    }
    EXPECT_LT(widest, 1);
    EXPECT_GT(widest, 0.9);
  }
}

// The plane through the target has the same size in both projections. With parallel rays, sizes are
// the same behind it.
TEST(Camera, OrthographicKeepsTheSizeAtTheTarget) {
  const VolumeGrid g = grid();
  const BoundingSphere sphere = bounding_sphere(g);
  Camera camera = default_camera(g);
  const CameraFrame frame = camera_frame(camera);
  const auto across = [&](bool orthographic, double behind) {
    camera.orthographic = orthographic;
    const Projection p = projection(camera, sphere, camera.target, 400, 300);
    return transformed(p.clip_from_world, frame.right * 5.0 + frame.forward * behind).x;
  };
  EXPECT_NEAR(across(true, 0), across(false, 0), 1e-12);
  EXPECT_NEAR(across(true, 20), across(true, 0), 1e-12);
  EXPECT_LT(across(false, 20), across(false, 0));
}

TEST(Camera, PanningFollowsThePointerWithParallelRays) {
  const VolumeGrid g = grid();
  Camera camera = default_camera(g, 1, /*orthographic=*/true);
  const Projection p =
      projection(panned(camera, 30, -20, 300), bounding_sphere(g), camera.target, 400, 300);
  const Vec3d ndc = transformed(p.clip_from_world, camera_frame(camera).forward * 7.0);
  EXPECT_NEAR(ndc.x, 30 / 200.0, 1e-9);
  EXPECT_NEAR(ndc.y, 20 / 150.0, 1e-9);
}

// The diagonals of a sheared volume have different lengths: the sphere contains all corners, and
// touches two.
TEST(Camera, DefaultShowsAllOfAShearedVolume) {
  for (const double tilt : {0.8, -0.8}) {
    VolumeGrid g = grid();
    g.direction = {1, tilt, 0, 0, std::sqrt(1 - tilt * tilt), 0.6, 0, 0, 0.8};
    const Camera camera = default_camera(g);
    const BoundingSphere sphere = bounding_sphere(g);
    const Projection p = projection(camera, sphere, sphere.centre, 480, 480);
    double farthest = 0, widest = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3d at =
          g.world({corner & 1 ? 64.0 : 0.0, corner & 2 ? 32.0 : 0.0, corner & 4 ? 16.0 : 0.0}) -
          sphere.centre;
      farthest = std::max(farthest, length(at));
      const Vec3d ndc = transformed(p.clip_from_world, at);
      widest = std::max({widest, std::abs(ndc.x), std::abs(ndc.y)});
      EXPECT_LE(std::abs(ndc.z), 1) << corner;
    }
    EXPECT_NEAR(farthest, sphere.radius, 1e-9);
    EXPECT_LT(widest, 1);
    EXPECT_GT(widest, 0.9);
  }
}

TEST(Camera, PanningKeepsTheTargetUnderThePointer) {
  const VolumeGrid g = grid();
  const Camera before = default_camera(g);
  const Camera after = panned(before, 30, -12, 480);
  const BoundingSphere sphere = bounding_sphere(g);
  const Projection p = projection(after, sphere, {}, 640, 480);
  const Vec3d ndc = transformed(p.clip_from_world, before.target);
  EXPECT_NEAR(ndc.x * 320, 30, 1e-6);
  EXPECT_NEAR(ndc.y * 240, 12, 1e-6);
}

TEST(Camera, OrbitStopsAtThePoles) {
  Camera camera;
  EXPECT_EQ(orbited(camera, 0, 500).elevation, 90);
  const CameraFrame top = camera_frame(orbited(camera, 0, 500));
  EXPECT_NEAR(length(top.right), 1, 1e-12);
  EXPECT_NEAR(dot(top.right, top.up), 0, 1e-12);
}

TEST(Camera, BoundedKeepsCamerasThatGesturesReach) {
  const VolumeGrid g = grid();
  const double radius = bounding_sphere(g).radius;
  Camera camera = panned(orbited(default_camera(g), 170, 30), 300, -200, 480);
  EXPECT_EQ(bounded(camera, g), camera);
  for (const double factor : {1e-9, 1e9}) {
    const Camera end = zoomed(camera, factor, radius);
    EXPECT_EQ(bounded(end, g), end);
  }
}

TEST(Camera, BoundedIsNearTheVolumeForEveryLink) {
  const VolumeGrid g = grid();
  const BoundingSphere sphere = bounding_sphere(g);
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double wild : {1e20, -1e300, infinity, std::nan("")}) {
    for (double Camera::*number : {&Camera::distance, &Camera::azimuth, &Camera::elevation,
                                   &Camera::roll, &Camera::field_of_view}) {
      for (double Vec3d::*axis : {&Vec3d::x, &Vec3d::y, &Vec3d::z}) {
        Camera camera = default_camera(g);
        camera.*number = wild;
        camera.target.*axis = wild;
        const Camera found = bounded(camera, g);
        EXPECT_LE(length(found.target - sphere.centre), 100 * sphere.radius);
        EXPECT_GT(found.distance, 0);
        EXPECT_LE(found.distance, 100 * sphere.radius);
        EXPECT_LE(std::abs(found.azimuth), 360);
        EXPECT_LE(std::abs(found.elevation), 90);
        const Projection p = projection(found, sphere, {}, 640, 480);
        for (const double m : p.clip_from_world) EXPECT_TRUE(std::isfinite(m));
        EXPECT_LT(p.near_plane, p.far_plane);
      }
    }
  }
}

}  // namespace
}  // namespace isosplat::render
