// Close-ups of the squares' kind, whose cells are drawn as triangles, compared with exact splats.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "native/headless/draw_image.h"
#include "tests/native/renderer_test.h"
#include "tests/native/test_volume.h"

namespace isosplat::render {
namespace {

constexpr int kSize = 320;

class RenderTrianglesGpu : public RendererTest {
 protected:
  /// The surface pixels of a kind, and its picture in `picture`.
  std::vector<SurfacePixel> draw(SplatKind kind, const std::string& name) {
    settings_.kind = kind;
    settings_.shading = Shading::exact;
    settings_.eye_dome = 0;
    renderer_->set_settings(settings_);
    renderer_->set_camera(camera_);
    const auto image = draw_image(*renderer_, kSize, kSize);
    EXPECT_TRUE(image) << image.error().message;
    keep(*image, name + (kind == SplatKind::quad ? "-triangles" : "-exact"));
    picture_ = image->rgba;
    auto pixels = renderer_->read_surface();
    EXPECT_TRUE(pixels);
    return std::move(*pixels);
  }

  struct Difference {
    int covered = 0;   // pixels of the exact picture with a surface
    int coverage = 0;  // pixels that only one of both covers
    int holes = 0;     // pixels that only the exact picture covers, with all pixels up to 4 px away
    int beyond = 0;    // pixels of both whose depths differ by more than half a cell
    double depth = 0;  // mean, in cells
    double normal = 0;  // mean, degrees
  };

  /// cell: its side in the world.
  Difference compare(const std::string& name, double cell = 1) {
    const auto exact = draw(SplatKind::exact, name), ours = draw(SplatKind::quad, name);
    Difference d;
    int both = 0;
    for (size_t i = 0; i < exact.size(); ++i) {
      d.covered += exact[i].hit;
      d.coverage += exact[i].hit != ours[i].hit;
      if (!exact[i].hit || !ours[i].hit) continue;
      ++both;
      const double off = std::abs(double(exact[i].depth) - double(ours[i].depth)) / cell;
      d.beyond += off > 0.5;
      d.depth += off;
      const double cosine = double(dot(exact[i].normal, ours[i].normal));
      d.normal += std::acos(std::min(1.0, std::abs(cosine))) * 180 / 3.14159265;
    }
    constexpr int kNear = 4;
    for (int y = kNear; y < kSize - kNear; ++y) {
      for (int x = kNear; x < kSize - kNear; ++x) {
        bool deep = !ours[size_t(y * kSize + x)].hit;
        for (int j = -kNear; deep && j <= kNear; ++j) {
          for (int i = -kNear; deep && i <= kNear; ++i) {
            deep = exact[size_t((y + j) * kSize + x + i)].hit;
          }
        }
        d.holes += deep;
      }
    }
    d.depth /= std::max(1, both);
    d.normal /= std::max(1, both);
    return d;
  }

  Camera camera_;
  RenderSettings settings_;
  std::vector<uint8_t> picture_;
};

// The surface fills the picture, and crosses the borders of chunks: any hole shows the background.
TEST_F(RenderTrianglesGpu, HaveNoHoles) {
  const TestVolume volume = sphere_volume({140, 140, 140});
  show_volume(*renderer_, volume, 6000, 6000);
  settings_.isosurfaces = {{6000, {0.85f, 0.8f, 0.7f}, 1}};
  for (const bool orthographic : {false, true}) {
    camera_ = default_camera(volume.grid);
    camera_.orthographic = orthographic;
    camera_.field_of_view /= 6;
    camera_.azimuth = 3;
    camera_.elevation = 2;
    const Difference d = compare(orthographic ? "sphere-orthographic" : "sphere-close");
    EXPECT_EQ(d.covered, kSize * kSize);
    EXPECT_EQ(d.coverage, 0);
    EXPECT_LT(d.depth, 0.01);
    EXPECT_LT(d.normal, 0.5);
  }
}

TEST_F(RenderTrianglesGpu, FollowShearedAxes) {
  VolumeGrid grid{{60, 50, 30}, {1, 1.25, 2}};
  grid.direction = {1, 0.6, 0, 0, 0.8, 0, 0, 0, 1};
  const Vec3d centre = grid.world({29.5, 24.5, 14.5});
  const TestVolume volume = sampled_volume(grid, [&](Vec3d p) { return 100 * length(p - centre); });
  show_volume(*renderer_, volume, 1500, 1500);
  settings_.isosurfaces = {{1500, {0.85f, 0.8f, 0.7f}, 1}};
  camera_ = default_camera(grid);
  camera_.distance *= 0.4;
  const Difference d = compare("sphere-sheared");
  EXPECT_GT(d.covered, 10000);
  EXPECT_LT(d.coverage, 0.005 * d.covered);  // the outline is a polygon
  EXPECT_LT(d.depth, 0.03);
  EXPECT_LT(d.normal, 1.5);
}

// Most cells with random corners have ambiguous faces. Polygons in place of curved outlines change
// up to 21 % of the pixels. With faces that are connected in the opposite way it is 32 % or more,
// and there are 328 holes instead of 46.
TEST_F(RenderTrianglesGpu, JoinWhereFacesAreAmbiguous) {
  uint32_t state = 7;
  const TestVolume volume = sampled_volume({24, 24, 2}, {1, 1, 1}, [&](Vec3d) {
    state = state * 1664525 + 1013904223;
    return double(state >> 24);
  });
  camera_ = default_camera(volume.grid);
  camera_.elevation = 80;
  camera_.distance *= 0.7;
  int holes = 0;
  for (const double isovalue : {90.5, 127.5, 170.5}) {
    show_volume(*renderer_, volume, isovalue, isovalue);
    settings_.isosurfaces = {{isovalue, {0.85f, 0.8f, 0.7f}, 1}};
    const Difference d = compare("noise-" + std::to_string(int(isovalue)));
    EXPECT_GT(d.covered, 10000);
    EXPECT_LT(d.coverage, 0.24 * d.covered) << isovalue;
    holes += d.holes;
  }
  EXPECT_LT(holes, 60);
}

TEST_F(RenderTrianglesGpu, AreClippedAtEveryPixel) {
  const TestVolume volume = sphere_volume({60, 60, 60});
  show_volume(*renderer_, volume, 2500, 2500);
  settings_.isosurfaces = {{2500, {0.85f, 0.8f, 0.7f}, 1}};
  settings_.clip_planes = {{{0.6, 0.3, 0.2}, 1.7}};
  camera_ = default_camera(volume.grid);
  camera_.distance *= 0.4;
  const Difference d = compare("sphere-clipped");
  EXPECT_GT(d.covered, 10000);
  EXPECT_LT(d.coverage, 0.002 * d.covered);
  EXPECT_LT(d.beyond, 0.005 * d.covered);
}

// The picture that is lit per vertex covers the same pixels as the layers.
TEST_F(RenderTrianglesGpu, AreLitWhereTheyAreInLayers) {
  const TestVolume volume = sphere_volume({60, 60, 60});
  show_volume(*renderer_, volume, 2500, 2500);
  settings_.isosurfaces = {{2500, {0.85f, 0.8f, 0.7f}, 1}};
  settings_.background = {0, 0, 0, 0};
  camera_ = default_camera(volume.grid);
  camera_.distance *= 0.6;
  const auto pixels = draw(SplatKind::quad, "sphere-lit");
  int different = 0;
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      const size_t from_top = size_t(kSize - 1 - y) * kSize + size_t(x);
      different += pixels[size_t(y) * kSize + size_t(x)].hit != (picture_[4 * from_top + 3] > 0);
    }
  }
  EXPECT_EQ(different, 0);
}

}  // namespace
}  // namespace isosplat::render
