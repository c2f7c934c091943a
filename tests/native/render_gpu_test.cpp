// Pictures of analytic fields, on whatever EGL offers (llvmpipe where there is no GPU). Thresholds
// are stated at each comparison.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "native/headless/draw_image.h"
#include "native/headless/egl_context.h"
#include "native/headless/ray_caster.h"
#include "tests/native/test_volume.h"

namespace isosplat {
namespace {

class RenderGpu : public ::testing::Test {
 protected:
  void SetUp() override {
    auto context = EglContext::create();
    ASSERT_TRUE(context) << context.error().message;
    context_ = std::move(*context);
    auto renderer = Renderer::create();
    ASSERT_TRUE(renderer) << renderer.error().message;
    renderer_ = std::move(*renderer);
  }

  void TearDown() override {
    renderer_.reset();
    context_.reset();
  }

  /// Keeps a picture where ISOSPLAT_TEST_PICTURES names a folder.
  static void keep(const Image& image, const std::string& name) {
    if (const char* folder = std::getenv("ISOSPLAT_TEST_PICTURES")) {
      ASSERT_TRUE(write_png(std::string(folder) + "/" + name + ".png", image));
    }
  }

  struct Difference {
    double holes = 0;       // pixels the reference hits and its neighbours do, but ours does not
    double silhouette = 0;  // differing pixels / the reference's
    double depth = 0;       // mean, in cells (smallest spacing)
    double normal = 0;      // mean, degrees
    int reference = 0;
  };

  Difference compare(const TestVolume& volume, double isovalue, int width, int height) {
    const auto pixels = renderer_->read_surface();
    EXPECT_TRUE(pixels);
    const RayCaster caster(volume.grid, volume.codes, volume.mapping.has_missing);
    const CameraFrame frame = camera_frame(renderer_->camera());
    const double cell =
        std::min({volume.grid.spacing.x, volume.grid.spacing.y, volume.grid.spacing.z});
    Difference d;
    int both = 0, differing = 0;
    std::vector<char> hit(size_t(width) * size_t(height));
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        const size_t i = size_t(y) * size_t(width) + size_t(x);
        const auto truth =
            caster.cast(renderer_->camera(), width, height, x, y, volume.mapping.isocode(isovalue));
        hit[i] = truth.has_value();
        const auto& ours = (*pixels)[i];
        d.reference += truth.has_value();
        const bool covered = ours.hit && ours.coverage >= 0.5f;
        differing += truth.has_value() != covered;
        if (!truth || !covered) continue;
        ++both;
        d.depth += std::abs(truth->depth - double(ours.depth)) / cell;
        const Vec3d n = frame.right * double(ours.normal.x) + frame.up * double(ours.normal.y) -
                        frame.forward * double(ours.normal.z);
        d.normal += std::acos(std::min(1.0, std::abs(dot(n, truth->normal)))) * 180 / 3.14159265;
      }
    }
    for (int y = 2; y < height - 2; ++y) {
      for (int x = 2; x < width - 2; ++x) {
        bool deep = true;
        for (int j = -2; j <= 2; ++j) {
          for (int i = -2; i <= 2; ++i) {
            deep = deep && hit[size_t(y + j) * size_t(width) + size_t(x + i)];
          }
        }
        d.holes += deep && !(*pixels)[size_t(y) * size_t(width) + size_t(x)].hit;
      }
    }
    d.silhouette = double(differing) / std::max(1, d.reference);
    d.depth /= std::max(1, both);
    d.normal /= std::max(1, both);
    return d;
  }

  std::unique_ptr<EglContext> context_;
  std::unique_ptr<Renderer> renderer_;
};

constexpr SplatKind kKinds[] = {SplatKind::quad, SplatKind::ellipse, SplatKind::blended,
                                SplatKind::exact};
constexpr const char* kKindNames[] = {"quad", "ellipse", "blended", "exact"};

TEST_F(RenderGpu, EveryKindDrawsASphere) {
  const TestVolume volume = sphere_volume({70, 70, 70});
  show_volume(*renderer_, volume, 2500, 2500);
  Camera camera = default_camera(volume.grid);
  camera.distance *= 0.55;
  renderer_->set_camera(camera);
  RenderSettings settings;
  settings.isosurfaces = {{2500, {0.85f, 0.8f, 0.7f}, 1}};
  for (const SplatKind kind : kKinds) {
    settings.kind = kind;
    renderer_->set_settings(settings);
    FrameStatistics statistics;
    const auto image = draw_image(*renderer_, 512, 512, &statistics);
    ASSERT_TRUE(image) << image.error().message;
    EXPECT_EQ(statistics.kind, kind);
    const char* name = kKindNames[static_cast<int>(kind)];
    keep(*image, std::string("sphere-") + name);
    const Difference d = compare(volume, 2500, 512, 512);
    EXPECT_GT(d.reference, 60000) << name;
    EXPECT_EQ(d.holes, 0) << name;
    // Largest share of differing pixels, mean depth error in cells, mean normal error in degrees.
    struct Limits {
      double silhouette, depth, normal;
    };
    constexpr Limits kLimits[] = {
        {0.06, 0.5, 3}, {0.01, 0.05, 2}, {0.0005, 0.02, 1}, {0.0005, 0.001, 0.05}};
    const Limits& limits = kLimits[static_cast<int>(kind)];
    EXPECT_LT(d.silhouette, limits.silhouette) << name;
    EXPECT_LT(d.depth, limits.depth) << name;
    EXPECT_LT(d.normal, limits.normal) << name;
  }
}

}  // namespace
}  // namespace isosplat
