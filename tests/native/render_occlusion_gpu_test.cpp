// Compares the values of ambient occlusion and shadows in still pictures with slow references on
// the CPU.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "native/headless/draw_image.h"
#include "shared/render/passes/lighting.h"
#include "shared/render/settings/colour_maps.h"
#include "tests/native/renderer_test.h"
#include "tests/native/test_volume.h"

namespace isosplat::render {
namespace {

constexpr int kSize = 200;
constexpr double kPi = 3.14159265358979;
constexpr float kGrey = 0.5f;

/// A ball that touches a plane: the nearest of both surfaces, at distance 0.
constexpr double kBallRadius = 12;
constexpr Vec3d kBall{31.5, 31.5, 17};
constexpr double kPlane = 6;
constexpr double kIsovalue = 10000;

TestVolume ball_on_plane() {
  return sampled_volume({64, 64, 44}, {1, 1, 1}, [](Vec3d p) {
    return kIsovalue - 200 * std::min(length(p - kBall) - kBallRadius, p.z - kPlane);
  });
}

class OcclusionGpu : public RendererTest {
 protected:
  void prepare() override {
    volume_ = ball_on_plane();
    show_volume(*renderer_, volume_, kIsovalue, kIsovalue);
    camera_ = default_camera(volume_.grid);
    camera_.elevation = 40;
    camera_.distance *= 0.7;
    renderer_->set_camera(camera_);
    settings_.kind = SplatKind::exact;
    settings_.isosurfaces = {{kIsovalue, {kGrey, kGrey, kGrey}, 1}};
    settings_.eye_dome = 0;
    settings_.light.rim = settings_.light.highlight = 0;
    settings_.light.occlusion = settings_.light.shadow = 0;
  }

  /// Linear light of each pixel of a still picture, rows upwards.
  std::vector<float> light() {
    renderer_->set_settings(settings_);
    const auto image = draw_image(*renderer_, kSize, kSize, nullptr, /*smooth=*/true);
    EXPECT_TRUE(image);
    std::vector<float> result;
    for (int y = kSize - 1; y >= 0; --y) {
      for (int x = 0; x < kSize; ++x) {
        result.push_back(srgb_to_linear(float(image->at(x, y)[1]) / 255));
      }
    }
    return result;
  }

  /// The position of the surface in a pixel, in the world.
  Vec3d world_position(int x, int y, double depth) const {
    const CameraFrame frame = camera_frame(camera_);
    const double per_px = frame.tan_half_field_of_view / (0.5 * kSize);
    return frame.eye + (frame.forward + frame.right * ((x + 0.5 - 0.5 * kSize) * per_px) +
                        frame.up * ((y + 0.5 - 0.5 * kSize) * per_px)) *
                           depth;
  }

  /// Whether a pixel is not at an outline: it and its neighbours show the surface at similar
  /// depths.
  static bool is_inside(const std::vector<SurfacePixel>& pixels, int x, int y) {
    const auto& here = pixels[size_t(y) * kSize + size_t(x)];
    if (!here.hit) return false;
    for (int j = -2; j <= 2; ++j) {
      for (int i = -2; i <= 2; ++i) {
        const auto& there = pixels[size_t(y + j) * kSize + size_t(x + i)];
        if (!there.hit || std::abs(there.depth - here.depth) > 4) return false;
      }
    }
    return true;
  }

  TestVolume volume_;
  Camera camera_;
  RenderSettings settings_;
};

/// Distance along a ray (unit length) to the ball; negative if it misses. `from` is outside.
double distance_to_ball(Vec3d from, Vec3d ray) {
  const Vec3d to_ball = kBall - from;
  const double along = dot(to_ball, ray);
  const double miss = dot(to_ball, to_ball) - along * along;
  if (along < 0 || miss > kBallRadius * kBallRadius) return -1;
  return along - std::sqrt(kBallRadius * kBallRadius - miss);
}

/// The share of the sky that a point of the surface sees, weighted by the cosine: computed by rays
/// over the whole hemisphere to the exact ball and plane. Occluders fade out in the outer half of
/// the radius.
double open_share(Vec3d at, Vec3d normal, double radius) {
  Vec3d u = cross(normal, std::abs(normal.z) < 0.9 ? Vec3d{0, 0, 1} : Vec3d{1, 0, 0});
  u = u * (1 / length(u));
  const Vec3d v = cross(normal, u);
  constexpr int kRings = 16, kTurns = 48;
  const Vec3d from = at + normal * 0.02;
  double open = 0;
  for (int i = 0; i < kRings; ++i) {
    for (int j = 0; j < kTurns; ++j) {
      const double across = std::sqrt((i + 0.5) / kRings), turn = 2 * kPi * (j + 0.5) / kTurns;
      const Vec3d ray = u * (across * std::cos(turn)) + v * (across * std::sin(turn)) +
                        normal * std::sqrt(1 - across * across);
      double nearest = distance_to_ball(from, ray);
      if (nearest < 0) nearest = 1e9;
      if (ray.z < 0) nearest = std::min(nearest, (kPlane - from.z) / ray.z);
      open += 1 - std::clamp(2 - 2 * nearest / radius, 0.0, 1.0);
    }
  }
  return open / (kRings * kTurns);
}

// The mean difference is below 0.03, and the difference of 95 % of the pixels below 0.1. The limits
// are not smaller, since the picture shows neither the back of the ball nor the regions that it
// hides.
TEST_F(OcclusionGpu, AmbientOcclusionEqualsTheIntegralOverTheHemisphere) {
  settings_.light.key = 0;
  settings_.light.sky = 2;
  const std::vector<float> open_light = light();
  const auto pixels = renderer_->read_surface();
  ASSERT_TRUE(pixels);
  settings_.light.occlusion = 1;
  const std::vector<float> occluded_light = light();
  const double radius =
      double(settings_.light.occlusion_radius) * visible_radius(volume_.grid, settings_);
  const float albedo = srgb_to_linear(kGrey);
  std::vector<double> differences;
  double least = 1, sum = 0;
  for (int y = 4; y < kSize - 4; y += 5) {
    for (int x = 4; x < kSize - 4; x += 5) {
      if (!is_inside(*pixels, x, y)) continue;
      const size_t i = size_t(y) * kSize + size_t(x);
      const Vec3d world = world_position(x, y, double((*pixels)[i].depth));
      const Vec3d out = world - kBall;
      const bool is_ball = length(out) < kBallRadius + 0.1;
      if (!is_ball && std::abs(world.z - kPlane) > 0.1) continue;  // a side of the volume
      const Vec3d normal = is_ball ? out * (1 / length(out)) : Vec3d{0, 0, 1};
      const double share = open_share(world, normal, radius);
      const double truth = double(with_reflections(float(share), albedo));
      const double ours = double(occluded_light[i] / open_light[i]);
      differences.push_back(std::abs(ours - truth));
      sum += differences.back();
      least = std::min(least, ours);
    }
  }
  ASSERT_GT(differences.size(), 300u);
  std::sort(differences.begin(), differences.end());
  EXPECT_LT(least, 0.6);  // it is dark below the ball
  EXPECT_LT(sum / double(differences.size()), 0.03);
  EXPECT_LT(differences[differences.size() * 95 / 100], 0.1);
}

/// The share of a disc-shaped light that a point of the plane sees past the ball.
double light_share(Vec3d at, Vec3d to_light, double softness) {
  Vec3d u = cross(to_light, std::abs(to_light.y) < 0.9 ? Vec3d{0, 1, 0} : Vec3d{1, 0, 0});
  u = u * (1 / length(u));
  const Vec3d v = cross(to_light, u);
  constexpr int kRays = 400;
  int open = 0;
  for (int i = 0; i < kRays; ++i) {
    const double across = softness * std::sqrt((i + 0.5) / kRays), turn = 2.39996323 * i;
    Vec3d ray = to_light + u * (across * std::cos(turn)) + v * (across * std::sin(turn));
    ray = ray * (1 / length(ray));
    open += distance_to_ball(at, ray) < 0;
  }
  return double(open) / kRays;
}

// On the plane, where the ball's front casts the shadow: mean difference below 0.05.
TEST_F(OcclusionGpu, ShadowsAreThoseOfAnAreaLight) {
  settings_.light.sky = 0;
  settings_.light.azimuth = -60;
  settings_.light.elevation = 50;
  settings_.light.shadow_softness = 0.15f;
  const std::vector<float> lit_light = light();
  const auto pixels = renderer_->read_surface();
  ASSERT_TRUE(pixels);
  settings_.light.shadow = 1;
  const std::vector<float> shadowed_light = light();
  const CameraFrame frame = camera_frame(camera_);
  const Vec3f key = light_terms(settings_.light, false).key_direction;
  const Vec3d to_light =
      frame.right * double(key.x) + frame.up * double(key.y) - frame.forward * double(key.z);
  double sum = 0, dark = 0, bright = 0;
  int count = 0, dark_count = 0, bright_count = 0;
  for (int y = 4; y < kSize - 4; y += 3) {
    for (int x = 4; x < kSize - 4; x += 3) {
      if (!is_inside(*pixels, x, y)) continue;
      const size_t i = size_t(y) * kSize + size_t(x);
      const Vec3d world = world_position(x, y, double((*pixels)[i].depth));
      if (std::abs(world.z - kPlane) > 0.05) continue;
      const double truth = light_share(world, to_light, 0.15);
      const double ours = double(shadowed_light[i] / lit_light[i]);
      sum += std::abs(ours - truth);
      ++count;
      if (truth == 0) dark += ours, ++dark_count;
      if (truth == 1) bright += ours, ++bright_count;
    }
  }
  ASSERT_GT(dark_count, 20);
  ASSERT_GT(bright_count, 200);
  EXPECT_LT(sum / count, 0.05);
  EXPECT_LT(dark / dark_count, 0.15);
  EXPECT_GT(bright / bright_count, 0.95);
}

// draw() computes neither occlusion nor shadows; they begin with refine(). Nothing occludes a plane
// that fills the image.
TEST_F(OcclusionGpu, StartsWithTheSecondPicture) {
  settings_.light.occlusion = settings_.light.shadow = 1;
  renderer_->set_settings(settings_);
  const auto first = draw_image(*renderer_, kSize, kSize);
  settings_.light.occlusion = settings_.light.shadow = 0;
  renderer_->set_settings(settings_);
  const auto plain = draw_image(*renderer_, kSize, kSize);
  ASSERT_TRUE(first && plain);
  EXPECT_EQ(first->rgba, plain->rgba);
}

// Settings may come from a link. Numbers out of range count as the nearest limit, NaN as the lower
// one.
TEST_F(OcclusionGpu, LimitsItsSettings) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  settings_.light.occlusion = settings_.light.shadow = 7;
  settings_.light.occlusion_radius = settings_.light.shadow_softness = kNan;
  settings_.light.key = settings_.light.sky = 1e30f;
  settings_.light.roughness = -1;
  const std::vector<float> outside = light();
  settings_.light.occlusion = settings_.light.shadow = 1;
  settings_.light.occlusion_radius = 0.001f;
  settings_.light.shadow_softness = 0.01f;
  settings_.light.key = settings_.light.sky = 2;
  settings_.light.roughness = 0.1f;
  EXPECT_EQ(outside, light());
}

// Also at the image's edges, and where the surface is seen at a grazing angle.
TEST_F(OcclusionGpu, DoesNotDarkenAPlane) {
  const TestVolume plane =
      sampled_volume({64, 64, 8}, {1, 1, 1}, [](Vec3d p) { return kIsovalue - 200 * (p.z - 3.3); });
  show_volume(*renderer_, plane, kIsovalue, kIsovalue);
  camera_ = default_camera(plane.grid);
  camera_.distance *= 0.25;
  settings_.light.key = settings_.light.sky = 1;
  for (const double elevation : {80.0, 25.0}) {
    camera_.elevation = elevation;
    renderer_->set_camera(camera_);
    settings_.light.occlusion = settings_.light.shadow = 0;
    const std::vector<float> open = light();
    const auto pixels = renderer_->read_surface();
    ASSERT_TRUE(pixels);
    settings_.light.occlusion = settings_.light.shadow = 1;
    const std::vector<float> occluded = light();
    int count = 0;
    for (int y = 2; y < kSize - 2; ++y) {
      for (int x = 2; x < kSize - 2; ++x) {
        const size_t i = size_t(y) * kSize + size_t(x);
        if (!is_inside(*pixels, x, y)) continue;
        ++count;
        EXPECT_NEAR(occluded[i], open[i], 0.02) << x << " " << y << " at " << elevation;
      }
    }
    EXPECT_GT(count, kSize * kSize / 2);
  }
}

// Colours that stand for values keep their hue, and stay within the stated range, whatever the
// light.
TEST_F(OcclusionGpu, ValueColoursStayReadable) {
  settings_.colour_by = ColourBy::isovalue;
  settings_.colour_low = 0;
  settings_.colour_high = 2 * kIsovalue;
  settings_.eye_dome = 1;
  settings_.light = LightSettings{};
  settings_.light.highlight = settings_.light.rim = 2;
  settings_.light.occlusion = settings_.light.shadow = 1;
  float least = 1, most = 0;
  for (const float key : {0.0f, 2.0f}) {
    settings_.light.key = key;
    settings_.light.sky = key;
    renderer_->set_settings(settings_);
    const auto image = draw_image(*renderer_, kSize, kSize, nullptr, /*smooth=*/true);
    const auto pixels = renderer_->read_surface();
    ASSERT_TRUE(image && pixels);
    const auto& table = kColourMapTable[static_cast<int>(settings_.colour_map)];
    const auto entry = [&](int i) {
      return to_linear(
          {float(table[i][0]) / 255, float(table[i][1]) / 255, float(table[i][2]) / 255});
    };
    const Vec3f legend = (entry(127) + entry(128)) * 0.5f;
    int count = 0;
    for (int y = 4; y < kSize - 4; ++y) {
      for (int x = 4; x < kSize - 4; ++x) {
        if (!is_inside(*pixels, x, y)) continue;
        const uint8_t* rgb = image->at(x, kSize - 1 - y);
        const Vec3f colour =
            to_linear({float(rgb[0]) / 255, float(rgb[1]) / 255, float(rgb[2]) / 255});
        const float factor = colour.y / legend.y;
        ++count;
        least = std::min(least, factor);
        most = std::max(most, factor);
        EXPECT_GE(factor, kLeastValueShading * kLeastEdgeShading - 0.01f);
        EXPECT_LE(factor, 1.02f);
        EXPECT_NEAR(colour.z / legend.z, factor, 0.03f);
        EXPECT_NEAR(colour.x / legend.x, factor, 0.15f);  // dark: one step of 255 is much
      }
    }
    EXPECT_GT(count, 5000);
  }
  EXPECT_LT(least, kLeastValueShading + 0.02f);  // the limit was reached
  EXPECT_GT(most, 0.98f);
}

}  // namespace
}  // namespace isosplat::render
