// Pictures of several volumes: one depth order, one light, picks and queries that name the volume.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <random>

#include "native/headless/draw_image.h"
#include "native/headless/ray_caster.h"
#include "tests/native/renderer_test.h"
#include "tests/native/test_volume.h"

namespace isosplat::render {
namespace {

constexpr int kSize = 256;

/// A ball around a position in the world: its isosurface at 100 r has the radius r.
TestVolume ball(Vec3d centre, double radius, const Matrix3d& axes, Vec3d spacing) {
  return sampled_volume(grid_about(centre, radius + 3, axes, spacing),
                        [centre](Vec3d p) { return 100 * length(p - centre); });
}

Matrix3d turned(double degrees) {
  const double c = std::cos(degrees * 3.14159265358979 / 180),
               s = std::sin(degrees * 3.14159265358979 / 180);
  return {c, s, 0, -s, c, 0, 0, 0, 1};
}

constexpr Matrix3d kSheared{1, 0.4, 0, 0, 1, 0, 0.2, 0, 1};

class SceneGpu : public RendererTest {
 protected:
  void add(VolumeId id, const TestVolume& volume, std::initializer_list<double> isovalues,
           float opacity = 1) {
    volumes_[id] = volume;
    for (const double isovalue : isovalues) {
      settings_.isosurfaces.push_back(
          {isovalue, colour_of(settings_.isosurfaces.size()), opacity, id});
    }
    const auto [low, high] = std::minmax(isovalues);
    show_volume(*renderer_, volumes_[id], low, high, 0, id);
  }

  static Vec3f colour_of(size_t i) {
    constexpr Vec3f kColours[] = {{0.9f, 0.3f, 0.2f}, {0.2f, 0.6f, 0.9f}, {0.4f, 0.8f, 0.3f}};
    return kColours[i % 3];
  }

  /// The default camera of the first volume, moved so that all volumes are in the image.
  Camera camera_of_all() const {
    Camera camera = default_camera(volumes_.begin()->second.grid);
    camera.target = {0, 0, 0};
    camera.distance = 110;
    return camera;
  }

  struct Truth {
    double depth;
    uint32_t isosurface;
    Vec3d normal;
  };
  /// The nearest of all isosurfaces at a pixel, by rays through each volume.
  std::optional<Truth> truth_at(const Camera& camera, int x, int y) {
    std::optional<Truth> nearest;
    for (uint32_t i = 0; i < settings_.isosurfaces.size(); ++i) {
      const Isosurface& surface = settings_.isosurfaces[i];
      const TestVolume& volume = volumes_.at(surface.volume);
      const auto caster = casters_.try_emplace(surface.volume, volume.grid, volume.quantized_values,
                                               /*has_missing=*/false);
      const auto hit = caster.first->second.cast(
          camera, kSize, kSize, x, y, volume.mapping.quantized_isovalue(surface.isovalue));
      if (hit && (!nearest || hit->depth < nearest->depth))
        nearest = Truth{hit->depth, i, hit->normal};
    }
    return nearest;
  }

  RenderSettings settings_;
  std::map<VolumeId, TestVolume> volumes_;
  std::map<VolumeId, RayCaster> casters_;
};

// Three grids that overlap: with perpendicular, turned and sheared axes, and different spacings.
TEST_F(SceneGpu, VolumesOfDifferentGridsHaveOneDepthOrder) {
  add(4, ball({-8, 0, 0}, 14, kIdentity3, {1, 1.2, 0.9}), {1400});
  add(7, ball({9, 3, 2}, 12, turned(30), {0.8, 0.8, 1.6}), {1200, 700});
  add(9, ball({0, -8, 10}, 10, kSheared, {0.7, 0.7, 0.7}), {1000});
  const Camera camera = camera_of_all();
  for (const SplatKind kind : {SplatKind::quad, SplatKind::ellipse, SplatKind::exact}) {
    settings_.kind = kind;
    settings_.shading = Shading::exact;
    draw_and_keep(settings_, camera, kSize, "scene-" + std::to_string(int(kind)));
    const auto pixels = renderer_->read_surface();
    ASSERT_TRUE(pixels);
    const CameraFrame frame = camera_frame(camera);
    int both = 0, differing = 0, other = 0;
    double depth = 0, normal = 0;
    for (int y = 0; y < kSize; y += 2) {
      for (int x = 0; x < kSize; x += 2) {
        const SurfacePixel& pixel = (*pixels)[size_t(y) * kSize + size_t(x)];
        const auto truth = truth_at(camera, x, y);
        differing += truth.has_value() != pixel.hit;
        if (!truth || !pixel.hit) continue;
        ++both;
        if (truth->isosurface != pixel.isosurface) {
          ++other;
          continue;
        }
        depth += std::abs(truth->depth - double(pixel.depth));
        const Vec3d n = frame.right * double(pixel.normal.x) + frame.up * double(pixel.normal.y) -
                        frame.forward * double(pixel.normal.z);
        normal += std::acos(std::min(1.0, std::abs(dot(n, truth->normal)))) * 180 / 3.14159265;
      }
    }
    EXPECT_GT(both, 2000);
    const bool is_quad = kind == SplatKind::quad;
    EXPECT_LE(differing, is_quad ? both / 20 : both / 100) << int(kind);
    EXPECT_LE(other, is_quad ? both / 40 : both / 200) << int(kind);
    EXPECT_LT(depth / both, is_quad ? 0.3 : 0.01) << int(kind);
    EXPECT_LT(normal / both, is_quad ? 3 : 0.5) << int(kind);
  }
}

/// In each pixel, the picture of the volume whose surface is nearest to the eye is expected.
TEST_F(SceneGpu, RandomScenesEqualTheMergedPicturesOfTheirVolumes) {
  std::mt19937 random(7);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  const char* cases = std::getenv("ISOSPLAT_SCENES");
  const int scenes = cases ? std::atoi(cases) : 25;
  for (int scene = 0; scene < scenes; ++scene) {
    SCOPED_TRACE(scene);
    for (const auto& [id, volume] : volumes_) renderer_->remove_volume(id);
    volumes_.clear();
    settings_ = {};
    settings_.kind = scene % 3 == 0 ? SplatKind::ellipse : SplatKind::exact;
    settings_.shading = scene % 2 == 0 ? Shading::smooth : Shading::exact;
    const int count = 1 + scene % 5;
    for (int i = 0; i < count; ++i) {
      const double radius = uniform(5, 14), spacing = uniform(0.7, 1.5);
      const Vec3d centre{uniform(-15, 15), uniform(-15, 15), uniform(-15, 15)};
      const Matrix3d axes = i % 2 == 0 ? turned(uniform(0, 90)) : kSheared;
      add(static_cast<VolumeId>(3 * i),
          ball(centre, radius, axes, {spacing, spacing, 1.2 * spacing}), {100 * radius});
    }
    Camera camera = camera_of_all();
    camera.azimuth = uniform(0, 360);
    camera.orthographic = scene % 4 == 3;
    draw_and_keep(settings_, camera, kSize, "random-scene-" + std::to_string(scene));
    const auto together = renderer_->read_surface();
    ASSERT_TRUE(together);
    std::vector<std::vector<SurfacePixel>> alone;
    const RenderSettings all = settings_;
    for (size_t i = 0; i < all.isosurfaces.size(); ++i) {
      RenderSettings one = all;
      for (size_t j = 0; j < all.isosurfaces.size(); ++j) {
        if (j != i) one.isosurfaces[j].opacity = 0;
      }
      draw_and_keep(one, camera, kSize, "alone");
      auto pixels = renderer_->read_surface();
      ASSERT_TRUE(pixels);
      alone.push_back(std::move(*pixels));
    }
    int differing = 0, shown = 0;
    for (size_t at = 0; at < together->size(); ++at) {
      const SurfacePixel* nearest = nullptr;
      for (const auto& pixels : alone) {
        if (pixels[at].hit && (!nearest || pixels[at].depth < nearest->depth))
          nearest = &pixels[at];
      }
      const SurfacePixel& found = (*together)[at];
      shown += found.hit;
      if (found.hit != (nearest != nullptr)) {
        ++differing;
      } else if (nearest) {
        const bool is_same = found.isosurface == nearest->isosurface &&
                             std::abs(found.depth - nearest->depth) < 1e-3f &&
                             dot(found.normal, nearest->normal) > 0.999f;
        differing += !is_same;
      }
    }
    EXPECT_GT(shown, 500);
    // Depths are rounded in the units of each volume. Where two surfaces meet, either may be in
    // front.
    EXPECT_LE(differing, 1 + shown / 2000);
  }
}

TEST_F(SceneGpu, TranslucentVolumesAreBlendedByDepth) {
  add(0, ball({0, 0, 0}, 8, kIdentity3, {1, 1, 1}), {800});
  add(1, ball({0, 0, 0}, 16, turned(45), {1, 1, 1}), {1600}, 0.5f);
  settings_.background = {0, 0, 0, 1};
  settings_.eye_dome = 0;
  const Image both = draw_and_keep(settings_, camera_of_all(), kSize, "translucent-scene");
  settings_.isosurfaces[1].opacity = 0;
  const Image inner = draw_and_keep(settings_, camera_of_all(), kSize, "translucent-scene-inner");
  const size_t middle = 4 * (kSize / 2 * kSize + kSize / 2);
  // The red ball is seen through the blue one, darker and bluer.
  EXPECT_LT(both.rgba[middle], inner.rgba[middle]);
  EXPECT_GT(both.rgba[middle + 2], inner.rgba[middle + 2]);
}

TEST_F(SceneGpu, MoreThan256SurfacesHaveTheirColours) {
  constexpr int kSide = 17;
  settings_.eye_dome = 0;
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const auto id = static_cast<VolumeId>(x + kSide * y);
      add(id, ball({6.0 * (x - 8), 0, 6.0 * (y - 8)}, 2, kIdentity3, {1, 1, 1}), {200});
      settings_.isosurfaces.back().colour = {x / 16.0f, y / 16.0f, 0.5f};
    }
  }
  Camera camera = camera_of_all();
  camera.azimuth = camera.elevation = 0;
  camera.orthographic = true;
  camera.distance = 200;
  const Image image = draw_and_keep(settings_, camera, kSize, "many-surfaces");
  const double px_per_unit = 0.5 * kSize / camera_frame(camera).half_height(1);
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const int px = int(kSize / 2 + 6.0 * (x - 8) * px_per_unit);
      const int py = int(kSize / 2 - 6.0 * (y - 8) * px_per_unit);
      const auto pick = renderer_->pick(px + 0.5, py + 0.5, kSize, kSize);
      ASSERT_TRUE(pick && *pick);
      EXPECT_EQ((*pick)->isosurface, uint32_t(x + kSide * y));
      const uint8_t* rgba = &image.rgba[4 * (size_t(py) * kSize + size_t(px))];
      EXPECT_EQ(rgba[0] > rgba[2], x > 8) << x << " " << y;
      if (x != 8) {
        EXPECT_NE(rgba[0], rgba[2]);
      }
    }
  }
}

TEST_F(SceneGpu, PicksNameTheSurfaceOfTheNearestVolume) {
  add(2, ball({0, -10, 0}, 6, kIdentity3, {1, 1, 1}), {600});
  add(5, ball({0, 10, 0}, 12, turned(20), {1, 1, 1}), {1200});
  Camera camera = camera_of_all();
  camera.azimuth = camera.elevation = 0;  // the eye is in front, at -y
  draw_and_keep(settings_, camera, kSize, "picks");
  const auto front = renderer_->pick(kSize / 2, kSize / 2, kSize, kSize);
  ASSERT_TRUE(front && *front);
  EXPECT_EQ((*front)->isosurface, 0u);
  EXPECT_NEAR((*front)->position.y, -16, 0.1);
  const double px_per_unit = 0.5 * kSize / camera_frame(camera).half_height(camera.distance);
  const auto behind = renderer_->pick(kSize / 2 + 9 * px_per_unit, kSize / 2, kSize, kSize);
  ASSERT_TRUE(behind && *behind);
  EXPECT_EQ((*behind)->isosurface, 1u);
  EXPECT_NEAR(length((*behind)->position - Vec3d{0, 10, 0}), 12, 0.1);
}

TEST_F(SceneGpu, TheClipBoxOfTheFirstVolumeCutsAllWithCaps) {
  add(0, ball({0, 0, 0}, 14, kIdentity3, {1, 1, 1}), {1400});
  add(1, ball({6, 0, 0}, 10, turned(30), {0.9, 0.9, 0.9}), {1000});
  // The values of these balls increase outwards, so the solid would be outside of the ball. Reverse
  // the values.
  for (auto& [id, volume] : volumes_) {
    for (QuantizedValue& value : volume.quantized_values)
      value = static_cast<QuantizedValue>(5000 - std::min<int>(value, 5000));
    show_volume(*renderer_, volume, 5000 - (id == 0 ? 1400 : 1000), 5000 - (id == 0 ? 1400 : 1000),
                0, id);
  }
  settings_.isosurfaces[0].isovalue = 3600;
  settings_.isosurfaces[1].isovalue = 4000;
  settings_.clip_box_low.y = 0.5;
  settings_.clip_caps = true;
  Camera camera = camera_of_all();
  camera.azimuth = camera.elevation = 0;
  for (const SplatKind kind : {SplatKind::ellipse, SplatKind::exact}) {
    settings_.kind = kind;
    draw_and_keep(settings_, camera, kSize, "scene-caps-" + std::to_string(int(kind)));
    const auto pixels = renderer_->read_surface();
    ASSERT_TRUE(pixels);
    const double px_per_unit = 0.5 * kSize / camera_frame(camera).half_height(camera.distance);
    const auto pixel_at = [&](double x, double z) {
      return (*pixels)[size_t(kSize / 2 + z * px_per_unit) * kSize +
                       size_t(kSize / 2 + x * px_per_unit)];
    };
    EXPECT_TRUE(pixel_at(-10, 0).cap);
    EXPECT_EQ(pixel_at(-10, 0).isosurface, 0u);
    EXPECT_TRUE(pixel_at(15.3, 0).cap);
    EXPECT_EQ(pixel_at(15.3, 0).isosurface, 1u);
    // In the same face, the cap of the later volume is in front of the other.
    for (const double x : {0.0, 3.0, 7.0, 11.0}) EXPECT_EQ(pixel_at(x, 2).isosurface, 1u) << x;
    EXPECT_FALSE(pixel_at(0, 20).hit);
    for (const double x : {-10.0, 3.0, 15.3}) {
      const auto pick = renderer_->pick(kSize / 2 + x * px_per_unit, kSize / 2, kSize, kSize);
      ASSERT_TRUE(pick && *pick);
      EXPECT_TRUE((*pick)->cap);
      EXPECT_EQ((*pick)->isosurface, x < 0 ? 0u : 1u);
    }
  }
}

TEST_F(SceneGpu, OcclusionQueriesSeeTheOtherVolumes) {
  add(0, ball({0, 20, 0}, 6, kIdentity3, {1, 1, 1}), {600});
  add(1, ball({0, -10, 0}, 16, kIdentity3, {1, 1, 1}), {1600});
  Camera camera = camera_of_all();
  camera.azimuth = camera.elevation = 0;
  const auto visible_regions = [&](VolumeId id) {
    const ChunkHandle handle = 0;
    EXPECT_TRUE(renderer_->begin_occlusion_query({&handle, 1}, 1, id));
    while (true) {
      if (const auto found = renderer_->take_occlusion_query()) {
        int count = 0;
        for (const uint32_t word : found->at(0).visible.words()) count += std::popcount(word);
        return count;
      }
    }
  };
  draw_and_keep(settings_, camera, kSize, "hidden-volume");
  EXPECT_EQ(visible_regions(0), 0);
  EXPECT_GT(visible_regions(1), 0);
  settings_.isosurfaces[1].opacity = 0;
  draw_and_keep(settings_, camera, kSize, "shown-volume");
  EXPECT_GT(visible_regions(0), 0);
}

TEST_F(SceneGpu, VolumesAreRemovedWithTheirChunks) {
  add(0, ball({-10, 0, 0}, 8, kIdentity3, {1, 1, 1}), {800});
  add(1, ball({10, 0, 0}, 8, kIdentity3, {1, 1, 1}), {800});
  draw_and_keep(settings_, camera_of_all(), kSize, "two");
  FrameStatistics before, after;
  ASSERT_TRUE(draw_image(*renderer_, kSize, kSize, &before));
  renderer_->remove_volume(0);
  EXPECT_TRUE(renderer_->needs_redraw(kSize, kSize));
  draw_and_keep(settings_, camera_of_all(), kSize, "one");
  ASSERT_TRUE(draw_image(*renderer_, kSize, kSize, &after));
  EXPECT_LT(after.samples_resident, before.samples_resident);
  const ChunkHandle handle = 0;
  EXPECT_FALSE(renderer_->begin_occlusion_query({&handle, 1}, 1, 0));
}

TEST_F(SceneGpu, AVolumeThatMovesKeepsItsChunks) {
  add(0, ball({-10, 0, 0}, 8, kIdentity3, {1, 1, 1}), {800});
  add(1, ball({10, 0, 0}, 8, kIdentity3, {1, 1, 1}), {800});
  const VolumeGrid before = volumes_[1].grid;
  const Camera camera = camera_of_all();
  const Image near = draw_and_keep(settings_, camera, kSize, "not-moved");
  VolumeGrid moved = before;
  moved.direction = kSheared;
  for (int column = 0; column < 3; ++column) {
    const double length =
        std::hypot(moved.direction[size_t(column)], moved.direction[size_t(3 + column)],
                   moved.direction[size_t(6 + column)]);
    for (int row = 0; row < 3; ++row) moved.direction[size_t(3 * row + column)] /= length;
  }
  moved.origin = before.origin + Vec3d{0, 12, 6};
  ASSERT_TRUE(renderer_->move_volume(moved, 1));
  EXPECT_TRUE(renderer_->needs_redraw(kSize, kSize));
  const Image after = draw_and_keep(settings_, camera, kSize, "moved");
  EXPECT_NE(near.rgba, after.rgba);

  // A moved volume gives the same picture as a volume that was set at this position.
  TestVolume there = volumes_[1];
  there.grid = moved;
  show_volume(*renderer_, there, 800, 800, 0, 1);
  EXPECT_EQ(draw_and_keep(settings_, camera, kSize, "set-there").rgba, after.rgba);

  ASSERT_TRUE(renderer_->move_volume(before, 1));
  EXPECT_EQ(draw_and_keep(settings_, camera, kSize, "moved-back").rgba, near.rgba);
  moved.voxels.x += 1;
  EXPECT_FALSE(renderer_->move_volume(moved, 1));
  EXPECT_FALSE(renderer_->move_volume(before, 2));
}

TEST_F(SceneGpu, TheGridOfTheSceneIsAroundAllVolumes) {
  EXPECT_EQ(renderer_->scene_grid().voxels.x, 2);
  add(3, ball({-10, 0, 0}, 8, turned(30), {1, 1, 1}), {800});
  EXPECT_EQ(renderer_->scene_grid().direction, volumes_[3].grid.direction);
  add(5, ball({10, 0, 0}, 8, kSheared, {1, 1, 1}), {800});
  const VolumeGrid scene = renderer_->scene_grid();
  for (const auto& [id, volume] : volumes_) {
    const Index3 voxels = volume.grid.voxels;
    const Vec3d last{voxels.x - 1.0, voxels.y - 1.0, voxels.z - 1.0};
    for (const Vec3d corner : {Vec3d{0, 0, 0}, Vec3d{last.x, 0, last.z}, last}) {
      const Vec3d at = volume.grid.world(corner);
      for (const double share :
           {(at.x - scene.origin.x) / scene.spacing.x, (at.y - scene.origin.y) / scene.spacing.y,
            (at.z - scene.origin.z) / scene.spacing.z}) {
        EXPECT_GE(share, -1e-9);
        EXPECT_LE(share, 1 + 1e-9);
      }
    }
  }
}

}  // namespace
}  // namespace isosplat::render
