// The orthographic camera, compared with the ray caster. Each comparison states its thresholds.
#include <gtest/gtest.h>

#include <GLES3/gl3.h>

#include <algorithm>
#include <cmath>

#include "native/headless/draw_image.h"
#include "native/headless/ray_caster.h"
#include "tests/native/renderer_test.h"
#include "tests/native/test_volume.h"

namespace isosplat::render {
namespace {

constexpr int kSize = 320;
constexpr SplatKind kKinds[] = {SplatKind::quad, SplatKind::ellipse, SplatKind::exact};
constexpr const char* kKindNames[] = {"quad", "ellipse", "exact"};

class OrthographicGpu : public RendererTest {
 protected:
  void prepare() override {
    settings_.shading = Shading::exact;  // as the reference
  }

  Image draw(const std::string& name) {
    return draw_and_keep(settings_, camera_, kSize, "orthographic-" + name);
  }

  struct Difference {
    int reference = 0;      // pixels of the reference
    double silhouette = 0;  // differing pixels / the reference's
    double depth = 0;       // mean, in cells
    double normal = 0;      // mean, degrees
  };

  Difference compare(const TestVolume& volume, double isovalue) {
    const auto pixels = renderer_->read_surface().value();
    const RayCaster caster(volume.grid, volume.quantized_values, volume.mapping.has_missing);
    const CameraFrame frame = camera_frame(camera_);
    const double cell =
        std::min({volume.grid.spacing.x, volume.grid.spacing.y, volume.grid.spacing.z});
    const double quantized = double(volume.mapping.quantized_isovalue(isovalue));
    Difference d;
    int both = 0, differing = 0;
    for (int y = 0; y < kSize; ++y) {
      for (int x = 0; x < kSize; ++x) {
        const auto truth = caster.cast(camera_, kSize, kSize, x, y, quantized);
        const auto& ours = pixels[size_t(y) * kSize + size_t(x)];
        d.reference += truth.has_value();
        differing += truth.has_value() != ours.hit;
        if (!truth || !ours.hit) continue;
        ++both;
        d.depth += std::abs(truth->depth - double(ours.depth)) / cell;
        const Vec3d n = frame.right * double(ours.normal.x) + frame.up * double(ours.normal.y) -
                        frame.forward * double(ours.normal.z);
        d.normal += std::acos(std::min(1.0, std::abs(dot(n, truth->normal)))) * 180 / 3.14159265;
      }
    }
    d.silhouette = double(differing) / std::max(1, d.reference);
    d.depth /= std::max(1, both);
    d.normal /= std::max(1, both);
    return d;
  }

  /// Draws each kind, and compares it with the reference.
  void expect_truth(const TestVolume& volume, double isovalue, const std::string& name) {
    // Largest share of differing pixels, mean depth error in cells, mean normal error in degrees.
    struct Limits {
      double silhouette, depth, normal;
    };
    constexpr Limits kLimits[] = {{0.03, 0.3, 2.5}, {0.005, 0.02, 0.5}, {0.001, 0.002, 0.05}};
    for (const SplatKind kind : kKinds) {
      settings_.kind = kind;
      const std::string full = name + "-" + kKindNames[static_cast<int>(kind)];
      draw(full);
      const Difference d = compare(volume, isovalue);
      const Limits& limits = kLimits[static_cast<int>(kind)];
      EXPECT_GT(d.reference, 5000) << full;
      EXPECT_LT(d.silhouette, limits.silhouette) << full;
      EXPECT_LT(d.depth, limits.depth) << full;
      EXPECT_LT(d.normal, limits.normal) << full;
    }
  }

  RenderSettings settings_;
  Camera camera_;
};

TEST_F(OrthographicGpu, EveryKindDrawsASphere) {
  const TestVolume volume = sphere_volume({70, 70, 70});
  show_volume(*renderer_, volume, 2500, 2500);
  settings_.isosurfaces = {{2500, {0.85f, 0.8f, 0.7f}, 1}};
  camera_ = default_camera(volume.grid, 1, /*orthographic=*/true);
  camera_.distance *= 1.1;
  expect_truth(volume, 2500, "sphere");
  // The silhouette of a sphere is a circle of its radius, wherever it is in the image.
  const double px = kSize / (2 * camera_frame(camera_).half_height(1));
  EXPECT_NEAR(compare(volume, 2500).reference, 3.14159265 * std::pow(25 * px, 2),
              0.01 * 3.14159265 * std::pow(25 * px, 2));
}

// In a close view, the eye is inside of the volume. An orthographic view also shows what is behind
// the eye.
TEST_F(OrthographicGpu, CloseViewsShowWhatIsBehindTheEye) {
  const TestVolume volume = sphere_volume({70, 70, 70});
  show_volume(*renderer_, volume, 2500, 2500);
  settings_.isosurfaces = {{2500, {0.85f, 0.8f, 0.7f}, 1}};
  camera_ = default_camera(volume.grid, 1, /*orthographic=*/true);
  camera_.distance *= 0.06;  // cells are large, and drawn as triangles by the exact kind
  expect_truth(volume, 2500, "close");
  EXPECT_EQ(compare(volume, 2500).reference, kSize * kSize);
}

TEST_F(OrthographicGpu, ShearedGridsAreTrue) {
  const Matrix3d axes = {1, 0.6, 0.2, 0.2, 0.8, -0.5, -0.1, 0.4, 0.9};
  const Vec3d centre{120, -80, 40};
  const TestVolume volume = sampled_volume(grid_about(centre, 20, axes, {1, 1.3, 0.9}),
                                           [&](Vec3d p) { return 100 * length(p - centre); });
  show_volume(*renderer_, volume, 2000, 2000);
  settings_.isosurfaces = {{2000, {0.85f, 0.8f, 0.7f}, 1}};
  camera_ = default_camera(volume.grid, 1, /*orthographic=*/true);
  expect_truth(volume, 2000, "sheared");
}

TEST_F(OrthographicGpu, ClippingCutsAlongTheRays) {
  const TestVolume volume = sphere_volume({70, 70, 70});
  show_volume(*renderer_, volume, 2500, 2500);
  settings_.isosurfaces = {{2500, {0.85f, 0.8f, 0.7f}, 1}};
  camera_ = default_camera(volume.grid, 1, /*orthographic=*/true);
  camera_.azimuth = camera_.elevation = 0;
  settings_.kind = SplatKind::exact;
  settings_.clip_box_low = {0, 0.5, 0};  // the half in front is cut away
  draw("clipped");
  const auto pixels = renderer_->read_surface().value();
  const auto& middle = pixels[size_t(kSize) * (kSize / 2) + kSize / 2];
  ASSERT_TRUE(middle.hit);
  EXPECT_NEAR(double(middle.depth), camera_.distance + 25, 0.01);  // the far wall, from inside
}

TEST_F(OrthographicGpu, OcclusionQueriesFindTheVisibleRegionsOnly) {
  const TestVolume volume = sphere_volume({129, 129, 129});
  show_volume(*renderer_, volume, 3000, 5000, 1);
  settings_.isosurfaces = {{5000, {1, 1, 1}, 1}, {3000, {1, 0, 0}, 1}};
  settings_.kind = SplatKind::exact;
  camera_ = default_camera(volume.grid, 1, /*orthographic=*/true);
  camera_.azimuth = camera_.elevation = 0;  // looks along +y
  for (const int min_px : {0, 1}) {
    draw("queries");
    const ChunkHandle handle = 0;
    ASSERT_TRUE(renderer_->begin_occlusion_query({&handle, 1}, min_px));
    glFinish();
    const auto answer = renderer_->take_occlusion_query();
    ASSERT_TRUE(answer);
    ASSERT_EQ(answer->size(), 1u);
    const RegionMask& visible = answer->at(0).visible;
    // Regions are 16 voxels wide. The outer sphere's front is at y = 14, its back at y = 114; the
    // inner one, of radius 30, is hidden.
    EXPECT_TRUE(visible.contains({4, 0, 4}) || visible.contains({3, 0, 3})) << min_px;
    EXPECT_FALSE(visible.contains({4, 7, 4})) << min_px;
    EXPECT_FALSE(visible.contains({4, 2, 4})) << min_px;
    int seen_behind = 0;
    for (int z = 2; z < 6; ++z) {
      for (int x = 2; x < 6; ++x) seen_behind += visible.contains({x, 6, z});
    }
    EXPECT_EQ(seen_behind, 0) << min_px;
  }
}

// Both cameras in turn: programs of one must not be used for the other.
TEST_F(OrthographicGpu, CamerasCanAlternate) {
  const TestVolume volume = sphere_volume({70, 70, 70});
  show_volume(*renderer_, volume, 2500, 2500);
  settings_.isosurfaces = {{2500, {0.85f, 0.8f, 0.7f}, 1}};
  settings_.shading = Shading::smooth;
  camera_ = default_camera(volume.grid);
  const Image perspective = draw("perspective");
  camera_.orthographic = true;
  const Image orthographic = draw("orthographic");
  EXPECT_NE(perspective.rgba, orthographic.rgba);
  camera_.orthographic = false;
  EXPECT_EQ(draw("perspective").rgba, perspective.rgba);
  camera_.orthographic = true;
  EXPECT_EQ(draw("orthographic").rgba, orthographic.rgba);
}

// Ambient occlusion and shadows in a hollow. The reference is a perspective view from afar, which
// is nearly orthographic.
TEST_F(OrthographicGpu, PicturesAtRestHaveTheSameLight) {
  const TestVolume volume = sphere_volume({70, 70, 70});
  show_volume(*renderer_, volume, 2500, 2500);
  settings_.isosurfaces = {{2500, {0.85f, 0.8f, 0.7f}, 1}};
  settings_.clip_box_low = {0.5, 0, 0};
  settings_.background = {0, 0, 0, 0};
  double mean[2] = {0, 0};
  for (const bool orthographic : {false, true}) {
    camera_ = default_camera(volume.grid);
    camera_.orthographic = orthographic;
    camera_.azimuth = -70;  // looks into the hollow
    camera_.field_of_view = 3;
    camera_.distance *= std::tan(15 / 57.29578) / std::tan(1.5 / 57.29578);
    renderer_->set_settings(settings_);
    renderer_->set_camera(camera_);
    const auto image = draw_image(*renderer_, kSize, kSize, nullptr, /*smooth=*/true);
    ASSERT_TRUE(image) << image.error().message;
    int pixels = 0;
    for (size_t i = 0; i < image->rgba.size(); i += 4) {
      if (image->rgba[i + 3] == 0) continue;
      mean[orthographic] += image->rgba[i];
      ++pixels;
    }
    ASSERT_GT(pixels, 10000);
    mean[orthographic] /= pixels;
  }
  EXPECT_NEAR(mean[0], mean[1], 2);
}

TEST_F(OrthographicGpu, KeepsTheProgramsOfBothCameras) {
  const TestVolume volume = sphere_volume({30, 30, 30});
  show_volume(*renderer_, volume, 1000, 1000);
  settings_.isosurfaces = {{1000, {1, 1, 1}, 1}};
  const auto linked = [&](bool orthographic) {
    camera_ = default_camera(volume.grid, 1, orthographic);
    renderer_->set_settings(settings_);
    renderer_->set_camera(camera_);
    FrameStatistics statistics;
    EXPECT_TRUE(draw_image(*renderer_, kSize, kSize, &statistics, false));
    return statistics.programs_linked;
  };
  EXPECT_GT(linked(false), 0u);
  EXPECT_GT(linked(true), 0u);
  EXPECT_EQ(linked(false), 0u);
  EXPECT_EQ(linked(true), 0u);
}

}  // namespace
}  // namespace isosplat::render
