// A picture that is drawn in tiles equals the same picture drawn at once.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "native/headless/draw_image.h"
#include "shared/render/frame/image_tile.h"
#include "tests/native/renderer_test.h"
#include "tests/native/test_volume.h"

namespace isosplat::render {
namespace {

/// Balls on a plane.
TestVolume balls_on_plane() {
  return sampled_volume({80, 40, 40}, {1, 1, 1}, [](Vec3d p) {
    double nearest = p.z - 6;
    for (int i = 0; i < 5; ++i) {
      const Vec3d ball{10.0 + 15 * i, 10.0 + 9 * (i % 3), 14.0 + 2 * i};
      nearest = std::min(nearest, length(p - ball) - 5.5);
    }
    return 10000 - 200 * nearest;
  });
}

/// A wall at the left end of a long plane.
TestVolume wall_on_plane() {
  return sampled_volume({120, 24, 24}, {1, 1, 1}, [](Vec3d p) {
    const double wall = std::max(std::abs(p.x - 10) - 2, p.z - 18);
    return 10000 - 200 * std::min(p.z - 4, wall);
  });
}

class TilesGpu : public RendererTest {
 protected:
  void prepare() override {
    show(balls_on_plane());
    settings_.isosurfaces = {{10000, {0.8f, 0.7f, 0.5f}, 1}};
    settings_.light.occlusion = settings_.light.shadow = 0;
  }
  void show(const TestVolume& volume) {
    show_volume(*renderer_, volume, 9800, 10000);
    camera_ = default_camera(volume.grid, double(width_) / height_);
    camera_.elevation = 35;
  }

  Image in_tiles(int pictures) {
    Image image{width_, height_, std::vector<uint8_t>(4 * size_t(width_) * size_t(height_))};
    EXPECT_TRUE(renderer_->begin_tiles(width_, height_));
    for (int top = 0; top < height_; top += tile_height_) {
      for (int left = 0; left < width_; left += tile_width_) {
        const int width = std::min(tile_width_, width_ - left);
        const int height = std::min(tile_height_, height_ - top);
        std::vector<uint8_t> rgba(4 * size_t(width) * size_t(height));
        const auto drawn = renderer_->draw_tile(left, top, width, height, pictures, rgba);
        EXPECT_TRUE(drawn) << drawn.error().message;
        for (int y = 0; y < height; ++y) {
          std::copy_n(&rgba[4 * size_t(y) * size_t(width)], 4 * size_t(width),
                      &image.rgba[4 * (size_t(top + y) * size_t(width_) + size_t(left))]);
        }
      }
    }
    renderer_->end_tiles();
    return image;
  }

  struct Difference {
    double share = 0;  // of pixels that differ by more than 2/255 in some channel
    double mean = 0;   // of all channels, in 1/255
  };
  /// pictures: of the tiles; 0: as many as the whole picture.
  Difference difference(bool smooth, const std::string& name, int pictures = 0) {
    renderer_->set_settings(settings_);
    renderer_->set_camera(camera_);
    const Image tiles = in_tiles(pictures > 0 ? pictures : smooth ? kStillPictures : 1);
    const Image whole = draw_image(*renderer_, width_, height_, nullptr, smooth).value();
    keep(tiles, "tiles-" + name);
    keep(whole, "whole-" + name);
    EXPECT_FALSE(whole.is_uniform());
    Difference d;
    for (size_t i = 0; i < whole.rgba.size(); i += 4) {
      int most = 0;
      for (size_t c = i; c < i + 4; ++c) {
        const int by = std::abs(int(whole.rgba[c]) - int(tiles.rgba[c]));
        most = std::max(most, by);
        d.mean += by;
      }
      d.share += most > 2;
    }
    d.share /= width_ * height_;
    d.mean /= 4.0 * width_ * height_;
    return d;
  }

  // Odd sizes, and tiles whose margins end within the picture.
  int width_ = 411, height_ = 167, tile_width_ = 103, tile_height_ = 90;
  RenderSettings settings_;
  Camera camera_;
};

// Rounding moves the outline of a splat at fewer than 1 in 2000 pixels.
TEST_F(TilesGpu, EqualTheWholePictureWithEveryKindOfSplats) {
  constexpr SplatKind kKinds[] = {SplatKind::quad, SplatKind::ellipse, SplatKind::exact};
  constexpr const char* kNames[] = {"quad", "ellipse", "exact"};
  for (const bool orthographic : {false, true}) {
    camera_.orthographic = orthographic;
    for (size_t i = 0; i < 3; ++i) {
      settings_.kind = kKinds[i];
      const std::string name = kNames[i] + std::string(orthographic ? "-orthographic" : "");
      EXPECT_LT(difference(/*smooth=*/false, name).share, 0.0005) << name;
    }
  }
}

TEST_F(TilesGpu, EqualTheWholePictureInCloseUps) {
  settings_.kind = SplatKind::ellipse;
  camera_.distance *= 0.25;  // cells become triangles, and the near plane cuts some
  EXPECT_LT(difference(/*smooth=*/false, "close").share, 0.0005);
}

TEST_F(TilesGpu, EqualTheWholePictureWithTranslucentSurfacesAndNoBackground) {
  settings_.kind = SplatKind::exact;
  settings_.isosurfaces = {{10000, {0.8f, 0.7f, 0.5f}, 1}, {9800, {0.2f, 0.4f, 0.9f}, 0.4f}};
  settings_.background = {1, 1, 1, 0};
  tile_width_ = 250;
  EXPECT_LT(difference(/*smooth=*/true, "translucent").share, 0.0005);
}

// Frames of films: fewer pictures, the same light and edges.
TEST_F(TilesGpu, MeansOfFewerPicturesAreCloseToTheWholePicture) {
  settings_.kind = SplatKind::exact;
  settings_.light.occlusion = settings_.light.shadow = 1;
  const double one = difference(/*smooth=*/true, "one", 1).mean;
  const double four = difference(/*smooth=*/true, "four", 4).mean;
  EXPECT_GT(four, 0);
  EXPECT_LT(four, one / 4);
}

TEST_F(TilesGpu, EqualTheWholePictureWithCaps) {
  settings_.kind = SplatKind::exact;
  settings_.clip_caps = true;
  settings_.clip_box_low = {0, 0.3, 0};
  settings_.clip_box_high = {0.9, 1, 1};
  settings_.light.occlusion = 1;
  EXPECT_LT(difference(/*smooth=*/true, "caps").share, 0.005);
}

// The wall casts its shadow from the first tile far into the second one, beyond the margin. There,
// the depths are those of a picture that is not shifted by a fraction of a pixel.
TEST_F(TilesGpu, EqualTheWholePictureWithOcclusionAndShadows) {
  std::tie(width_, height_, tile_width_, tile_height_) = std::tuple{100, 1400, 100, 450};
  show(wall_on_plane());
  camera_.azimuth = 90;
  camera_.elevation = 80;
  camera_.distance = 240;  // the plane is 1300 px long
  settings_.kind = SplatKind::exact;
  settings_.light.azimuth = 0;
  settings_.light.elevation = 75;
  settings_.light.occlusion = settings_.light.shadow = 1;
  const Difference d = difference(/*smooth=*/true, "occlusion");
  EXPECT_LT(d.share, 0.005);
  EXPECT_LT(d.mean, 0.05);
}

TEST_F(TilesGpu, RefusePartsOutsideOfThePicture) {
  std::vector<uint8_t> rgba(4 * 16 * 16);
  const auto status = [&](int x, int y) {
    const auto drawn = renderer_->draw_tile(x, y, 16, 16, 1, rgba);
    return drawn ? Status::ok : drawn.error().status;
  };
  EXPECT_EQ(status(0, 0), Status::invalid_argument) << "no picture has begun";
  ASSERT_TRUE(renderer_->begin_tiles(100, 50));
  EXPECT_EQ(status(84, 34), Status::ok);
  EXPECT_EQ(status(85, 34), Status::invalid_argument);
  EXPECT_EQ(status(84, 35), Status::invalid_argument);
  EXPECT_EQ(status(-1, 0), Status::invalid_argument);
  rgba.pop_back();
  EXPECT_EQ(status(0, 0), Status::invalid_argument);
  EXPECT_EQ(renderer_->begin_tiles(0, 1).error().status, Status::invalid_argument);
  EXPECT_EQ(renderer_->begin_tiles(1, kMaxImageSize + 1).error().status, Status::invalid_argument);
  renderer_->end_tiles();
  EXPECT_TRUE(renderer_->needs_redraw(100, 50));
}

}  // namespace
}  // namespace isosplat::render
