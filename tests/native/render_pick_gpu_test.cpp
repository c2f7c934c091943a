// Picks on surfaces, compared with the ray caster, which has the voxels in double precision.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "native/headless/ray_caster.h"
#include "shared/render/pick/ray_hits.h"
#include "tests/native/renderer_test.h"
#include "tests/native/test_volume.h"

namespace isosplat::render {
namespace {

constexpr int kWidth = 200, kHeight = 150;

class PickGpu : public RendererTest {
 protected:
  std::optional<SurfacePick> pick(double x, double y) {
    renderer_->set_settings(settings_);
    renderer_->set_camera(camera_);
    const auto found = renderer_->pick(x, y, kWidth, kHeight);
    EXPECT_TRUE(found) << found.error().message;
    return found.value_or(std::nullopt);
  }

  /// Picks at many pixels, and compares each with the ray caster.
  void expect_truth(const TestVolume& volume, double isovalue) {
    const RayCaster caster(volume.grid, volume.quantized_values, volume.mapping.has_missing);
    const CameraFrame frame = camera_frame(camera_);
    const double quantized = double(volume.mapping.quantized_isovalue(isovalue));
    int hits = 0, misses = 0;
    for (int y = 3; y < kHeight; y += 7) {
      for (int x = 2; x < kWidth; x += 7) {
        // Rows of the ray caster count from below.
        const auto truth = caster.cast(camera_, kWidth, kHeight, x, kHeight - 1 - y, quantized);
        const auto ours = pick(x + 0.5, y + 0.5);
        ASSERT_EQ(truth.has_value(), ours.has_value()) << x << ", " << y;
        ++(truth ? hits : misses);
        if (!truth) continue;
        EXPECT_NEAR(dot(ours->position - frame.eye, frame.forward), truth->depth, 1e-3);
        EXPECT_GT(std::abs(dot(ours->normal, truth->normal)), 0.99999);
        EXPECT_NEAR(length(volume.grid.world(ours->voxel) - ours->position), 0, 1e-9);
        EXPECT_EQ(ours->level, 0u);
      }
    }
    EXPECT_GT(hits, 50);
    EXPECT_GT(misses, 10);
  }

  RenderSettings settings_;
  Camera camera_;
};

TEST_F(PickGpu, FindsTheSurfaceOfACell) {
  const TestVolume volume = sphere_volume({70, 60, 40}, {1, 1.2, 1.7});
  show_volume(*renderer_, volume, 2500, 2500);
  settings_.isosurfaces = {{2500, {1, 1, 1}, 1}};
  for (const bool orthographic : {false, true}) {
    camera_ = default_camera(volume.grid, double(kWidth) / kHeight, orthographic);
    expect_truth(volume, 2500);
  }
}

TEST_F(PickGpu, FindsItInShearedGrids) {
  const Matrix3d axes = {1, 0.6, 0.2, 0.2, 0.8, -0.5, -0.1, 0.4, 0.9};
  const Vec3d centre{120, -80, 40};
  const TestVolume volume = sampled_volume(grid_about(centre, 20, axes, {1, 1.3, 0.9}),
                                           [&](Vec3d p) { return 100 * length(p - centre); });
  show_volume(*renderer_, volume, 2000, 2000);
  settings_.isosurfaces = {{2000, {1, 1, 1}, 1}};
  camera_ = default_camera(volume.grid, double(kWidth) / kHeight);
  expect_truth(volume, 2000);
}

TEST_F(PickGpu, ReturnsTheSurfaceAndTheDistanceToTheNextOne) {
  const TestVolume volume = sphere_volume({70, 70, 70});
  show_volume(*renderer_, volume, 1000, 2500);
  settings_.isosurfaces = {{1000, {1, 1, 1}, 1}, {2500, {1, 0, 0}, 0.4f}};
  camera_ = default_camera(volume.grid, double(kWidth) / kHeight);
  auto found = pick(kWidth / 2.0, kHeight / 2.0);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->isosurface, 1u);
  EXPECT_NEAR(length(found->position - Vec3d{34.5, 34.5, 34.5}), 25, 0.02);
  EXPECT_NEAR(found->to_next, 15, 0.05);
  EXPECT_NEAR(found->gradient, 100, 1);

  settings_.isosurfaces[1].opacity = 0;  // hidden surfaces are not picked
  found = pick(kWidth / 2.0, kHeight / 2.0);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->isosurface, 0u);
  EXPECT_NEAR(found->to_next, 20, 0.05);

  // Clipped parts cannot be picked, so the pick finds the far wall from inside.
  const Vec3d toward = camera_frame(camera_).forward;
  settings_.clip_planes = {{toward, dot(toward, Vec3d{34.5, 34.5, 34.5})}};
  found = pick(kWidth / 2.0, kHeight / 2.0);
  ASSERT_TRUE(found);
  EXPECT_NEAR(dot(found->position - Vec3d{34.5, 34.5, 34.5}, toward), 10, 0.02);
  EXPECT_LT(dot(found->normal, toward), 0);
  EXPECT_EQ(found->to_next, 0);
  settings_.clip_box_high = {0, 0, 0};
  EXPECT_FALSE(pick(kWidth / 2.0, kHeight / 2.0));
}

TEST_F(PickGpu, NeedsAVolumeAndToleratesAnyPosition) {
  EXPECT_EQ(renderer_->pick(1, 1, kWidth, kHeight).error().status, Status::invalid_argument);
  const TestVolume volume = sphere_volume({20, 20, 20});
  show_volume(*renderer_, volume, 500, 500);
  settings_.isosurfaces = {{500, {1, 1, 1}, 1}};
  camera_ = default_camera(volume.grid);
  for (const double place : {-1e9, 1e9, std::numeric_limits<double>::quiet_NaN(),
                             std::numeric_limits<double>::infinity()}) {
    EXPECT_FALSE(pick(place, 10));
  }
}

// A decoder never makes such samples, but damaged memory must not end the program.
TEST(SurfacePick, ToleratesSamplesOfAnyBytes) {
  VolumeGrid grid;
  grid.voxels = {65, 65, 65};
  const auto ray =
      pick_ray(grid, {bounding_sphere(grid), grid}, {}, default_camera(grid), {50, 50, 100, 100});
  ASSERT_TRUE(ray);
  std::vector<PackedSample> samples(5000);
  uint32_t bits = 1;
  for (PackedSample& sample : samples) {
    for (uint32_t& word : sample.word) word = bits = bits * 1664525 + 1013904223;
  }
  std::vector<PickHit> hits;
  const float isovalues[] = {30000, std::numeric_limits<float>::quiet_NaN()};
  add_hits(*ray, {0, {0, 0, 0}}, samples, isovalues, hits);
  for (const PickHit& hit : hits) EXPECT_EQ(hit.isosurface, 0u);
}

}  // namespace
}  // namespace isosplat::render
