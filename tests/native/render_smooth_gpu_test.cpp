// Compares smooth normals with the core's sums of gradients, and tests that they are continuous
// across cells, chunks, blocks and levels. Thresholds are stated at each comparison.
#include <GLES3/gl3.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "native/headless/draw_image.h"
#include "native/headless/offscreen_target.h"
#include "shared/core/sampling/smooth_gradients.h"
#include "tests/native/renderer_test.h"
#include "tests/native/test_volume.h"

namespace isosplat::render {
namespace {

constexpr int kSize = 256;
constexpr double kDegrees = 180 / 3.14159265358979323846;

double angle(Vec3d a, Vec3d b) {
  return std::atan2(length(cross(a, b)), dot(a, b)) * kDegrees;
}

/// Marschner and Lobb's test signal (1994) on [−1, 1]³, from 0 to 10000.
TestVolume marschner_lobb() {
  constexpr double kPi = 3.14159265358979323846;
  return sampled_volume({41, 41, 41}, {1, 1, 1}, [](Vec3d index) {
    const Vec3d p = index * (1.0 / 20) - Vec3d{1, 1, 1};
    const double rho = std::cos(12 * kPi * std::cos(0.5 * kPi * std::hypot(p.x, p.y)));
    return 10000 * (1 - std::sin(0.5 * kPi * p.z) + 0.25 * (1 + rho)) / 2.5;
  });
}

/// Adds the samples of a block to the reference.
void add_cells(SmoothGradients& gradients, BlockKey block, std::span<const PackedSample> samples) {
  for (const PackedSample& packed : samples) {
    const UnpackedSample sample = unpack_sample(packed);
    const Index3 first{block.index.x * kBlockCells, block.index.y * kBlockCells,
                       block.index.z * kBlockCells};
    gradients.add(block.level,
                  {first.x + sample.cell.x, first.y + sample.cell.y, first.z + sample.cell.z},
                  sample.corners);
  }
}

class RenderSmoothGpu : public RendererTest {
 protected:
  void prepare() override { settings_.kind = SplatKind::exact; }

  /// The surface that is seen, with normals in the world.
  struct Pixel {
    bool hit = false;
    Vec3d position, normal;  // of unit length
    uint32_t isosurface = 0;
    double depth = 0;
  };
  /// The surface pixels of the last picture of draw_still() if is_still, else of draw().
  std::vector<Pixel> draw(bool is_still = false) {
    renderer_->set_settings(settings_);
    renderer_->set_camera(camera_);
    EXPECT_TRUE(draw_image(*renderer_, kSize, kSize, nullptr, is_still));
    const auto pixels = renderer_->read_surface().value();
    const CameraFrame frame = camera_frame(camera_);
    std::vector<Pixel> result(pixels.size());
    for (size_t i = 0; i < pixels.size(); ++i) {
      const auto& from = pixels[i];
      if (!from.hit) continue;
      const auto across = [&](size_t at) {
        return (double(at) + 0.5 - 0.5 * kSize) * 2 * frame.tan_half_field_of_view / kSize;
      };
      const Vec3d ray =
          frame.forward + frame.right * across(i % kSize) + frame.up * across(i / kSize);
      result[i] = {true, frame.eye + ray * double(from.depth),
                   frame.right * double(from.normal.x) + frame.up * double(from.normal.y) -
                       frame.forward * double(from.normal.z),
                   from.isosurface, double(from.depth)};
    }
    return result;
  }

  /// The mean of the first two still pictures.
  std::vector<uint8_t> refined_once() {
    const OffscreenTarget target(kSize, kSize);
    EXPECT_TRUE(renderer_->draw(kSize, kSize, target.framebuffer()));
    EXPECT_TRUE(renderer_->refine(kSize, kSize, target.framebuffer()));
    std::vector<uint8_t> pixels(size_t{4} * kSize * kSize);
    glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer());
    glReadPixels(0, 0, kSize, kSize, GL_RGBA, GL_UNSIGNED_BYTE, pixels.data());
    return pixels;
  }

  /// Looks at the surface near a point from this distance.
  void look_at(Vec3d target, double distance) {
    camera_.target = target;
    camera_.distance = distance;
  }

  /// The jumps of the normal across faces of cells of level 0, in ascending order. A jump is
  /// computed from four pixels in a row or a column, two of which are in one cell and two in
  /// another: the angle in the middle, less the larger one of the angles beside it. The depths of
  /// neighbours differ by less than 0.2.
  static std::vector<double> jumps(const std::vector<Pixel>& pixels) {
    const auto is_near = [&](size_t a, size_t b) {
      return pixels[a].hit && pixels[b].hit && std::abs(pixels[a].depth - pixels[b].depth) < 0.2;
    };
    const auto cell = [&](size_t i) {
      const Vec3d p = pixels[i].position;
      return Vec3d{std::floor(p.x), std::floor(p.y), std::floor(p.z)};
    };
    std::vector<double> result;
    for (size_t i = 0; i < pixels.size(); ++i) {
      for (const size_t by : {size_t{1}, size_t{kSize}}) {
        const size_t p[4] = {i, i + by, i + 2 * by, i + 3 * by};
        if (p[3] >= pixels.size() || (by == 1 && i % kSize + 3 >= kSize)) continue;
        if (!is_near(p[0], p[1]) || !is_near(p[1], p[2]) || !is_near(p[2], p[3])) continue;
        if (cell(p[0]) != cell(p[1]) || cell(p[1]) == cell(p[2]) || cell(p[2]) != cell(p[3])) {
          continue;
        }
        const auto step = [&](int k) {
          return angle(pixels[p[k]].normal, pixels[p[k + 1]].normal);
        };
        result.push_back(step(1) - std::max(step(0), step(2)));
      }
    }
    std::sort(result.begin(), result.end());
    return result;
  }

  RenderSettings settings_;
  Camera camera_;
};

double percentile(const std::vector<double>& sorted, double share) {
  return sorted[static_cast<size_t>(share * double(sorted.size() - 1))];
}

// Angles are below 0.1° in all but 1 of 1000 pixels: normals have 16 bits, and depths 24.
TEST_F(RenderSmoothGpu, NormalsAreThoseOfTheCore) {
  for (const Vec3d spacing : {Vec3d{1, 1, 1}, Vec3d{1, 1.5, 2}}) {
    const TestVolume volume = sphere_volume({70, 70, 70}, spacing);
    show_volume(*renderer_, volume, 2300, 2700);  // some cells are not active
    SmoothGradients gradients;
    for (int block = 0; block < 8; ++block) {
      const BlockKey key{0, {block & 1, block >> 1 & 1, block >> 2}};
      add_cells(gradients, key, block_samples(volume, key, 2300, 2700));
    }
    settings_.isosurfaces = {{2500, {1, 1, 1}, 1}};
    const Vec3d centre = volume.grid.world({34.5, 34.5, 34.5});
    for (const double distance : {60.0, 20.0, 3.0}) {
      for (const SplatKind kind : {SplatKind::exact, SplatKind::ellipse}) {
        SCOPED_TRACE(distance);
        settings_.kind = kind;
        const Vec3d out = camera_frame(camera_).forward * -1.0;
        look_at(centre + out * 25.0, distance);
        const auto pixels = draw();
        int hits = 0, differing = 0;
        for (const Pixel& pixel : pixels) {
          if (!pixel.hit) continue;
          ++hits;
          const Vec3d index = multiply_transposed(volume.grid.dual_edges(), pixel.position);
          const Vec3d truth = volume.grid.world_gradient(gradients.at(index));
          differing += angle(pixel.normal, truth) > 0.1;
        }
        EXPECT_GT(hits, 20000);
        EXPECT_LE(differing, hits / 1000);
      }
    }
  }
}

// Across cells, chunks and blocks, the 95th percentile of jumps is below 0.1°, and no jump reaches
// 2°. The gradients of single cells jump more.
TEST_F(RenderSmoothGpu, NormalsAreContinuous) {
  struct Case {
    TestVolume volume;
    double isovalue;
    Vec3d target;
    double exact_jump;  // at least, at the 95th percentile
  };
  const Case cases[] = {{sphere_volume({130, 130, 130}), 2500, {64.5, 40, 64.5}, 0.5},
                        {marschner_lobb(), 5000, {20, 20, 20}, 10}};
  for (const auto& [volume, isovalue, target, exact_jump] : cases) {
    show_volume(*renderer_, volume, isovalue, isovalue);
    settings_.isosurfaces = {{isovalue, {1, 1, 1}, 1}};
    look_at(target, 18);
    camera_.elevation = 40;
    for (const Shading shading : {Shading::smooth, Shading::exact}) {
      settings_.shading = shading;
      const auto found = jumps(draw());
      ASSERT_GT(found.size(), size_t{1000});
      if (shading == Shading::smooth) {
        EXPECT_LT(percentile(found, 0.95), 0.1) << isovalue;
        EXPECT_LT(found.back(), 2) << isovalue;
      } else {
        EXPECT_GT(percentile(found, 0.95), exact_jump) << isovalue;
      }
    }
  }
}

// Level 0 beside level 1: no jump exceeds 0.5°. Fine cells have the normals of the sphere to within
// 1°, except beside coarse cells.
TEST_F(RenderSmoothGpu, NormalsAreContinuousBetweenLevels) {
  const TestVolume volume = sphere_volume({129, 65, 65});
  renderer_->set_volume(volume.grid, volume.mapping);
  const BlockKey fine{0, {0, 0, 0}}, coarse{1, {0, 0, 0}};
  ASSERT_TRUE(renderer_->add_chunk(0, fine, block_samples(volume, fine, 2500, 2500)));
  ASSERT_TRUE(renderer_->add_chunk(1, coarse, block_samples(volume, coarse, 2500, 2500)));
  RegionMask coarse_regions;
  for (int z = 0; z < 8; ++z) {
    for (int y = 0; y < 8; ++y) {
      for (int x = 4; x < 8; ++x) coarse_regions.insert({x, y, z});
    }
  }
  const DrawnChunk chunks[2] = {{0}, {1, coarse_regions}};
  renderer_->set_visible(chunks);
  settings_.isosurfaces = {{2500, {1, 1, 1}, 1}};
  camera_.elevation = 0;
  camera_.azimuth = 0;
  look_at({64, 32 - 25, 32}, 20);
  settings_.shading = Shading::exact;
  const auto exact = jumps(draw());
  settings_.shading = Shading::smooth;
  const auto pixels = draw();
  const auto smooth = jumps(pixels);
  EXPECT_GT(exact.back(), 2);
  EXPECT_LT(smooth.back(), 0.5);
  int fine_pixels = 0;
  for (const Pixel& pixel : pixels) {
    if (!pixel.hit || pixel.position.x > 63) continue;
    ++fine_pixels;
    EXPECT_LT(angle(pixel.normal, pixel.position - Vec3d{64, 32, 32}), 1);
  }
  EXPECT_GT(fine_pixels, 10000);
}

// Other isosurfaces do not influence the normals of an isosurface, and a cut does not change the
// normals beside it.
TEST_F(RenderSmoothGpu, NormalsDependOnTheirSurfaceAlone) {
  const TestVolume volume = sphere_volume({60, 60, 60});
  show_volume(*renderer_, volume, 1900, 2100);
  const Isosurface outer{2100, {1, 1, 1}, 1}, inner{1900, {1, 0, 0}, 1};
  look_at({29.5, 29.5, 29.5}, 70);
  settings_.isosurfaces = {outer, inner};
  const auto both = draw();
  settings_.isosurfaces = {outer};
  const auto alone = draw();
  settings_.clip_planes = {{{0.8, 0.36, 0.48}, 40}};
  const auto cut = draw();
  int of_outer = 0, left = 0;
  for (size_t i = 0; i < both.size(); ++i) {
    if (both[i].hit && both[i].isosurface == 0) {
      ++of_outer;
      EXPECT_LT(angle(both[i].normal, alone[i].normal), 0.02);
    }
    if (cut[i].hit && std::abs(cut[i].depth - alone[i].depth) < 1e-3) {
      ++left;
      EXPECT_LT(angle(cut[i].normal, alone[i].normal), 0.02);
    }
  }
  EXPECT_GT(of_outer, 20000);
  EXPECT_GT(left, 2000);
  EXPECT_LT(left, of_outer - 2000);
}

// Translucent surfaces have separate layers. The normals of each change from exact to smooth.
TEST_F(RenderSmoothGpu, TranslucentSurfacesAreSmooth) {
  const TestVolume volume = marschner_lobb();
  show_volume(*renderer_, volume, 4000, 5000);
  look_at({20, 20, 20}, 20);
  camera_.elevation = 50;
  const Isosurface behind{5000, {1, 1, 1}, 1}, before{4000, {1, 0.5f, 0}, 0.5f};
  const auto picture = [&](std::vector<Isosurface> isosurfaces, Shading shading) {
    settings_.isosurfaces = std::move(isosurfaces);
    settings_.shading = shading;
    renderer_->set_settings(settings_);
    renderer_->set_camera(camera_);
    return draw_image(*renderer_, kSize, kSize).value().rgba;
  };
  EXPECT_NE(picture({before}, Shading::smooth), picture({before}, Shading::exact));
  EXPECT_NE(picture({behind, before}, Shading::smooth), picture({behind, before}, Shading::exact));
}

// draw() leaves the exact normals of cells below 3 px, and smooths those of cells of 4 px or more.
// In still pictures, these limits are 0.5 and 1 px.
TEST_F(RenderSmoothGpu, AppliesToCellsThatAreLargeEnough) {
  const TestVolume volume = sphere_volume({70, 70, 70});
  show_volume(*renderer_, volume, 2500, 2500);
  settings_.isosurfaces = {{2500, {1, 1, 1}, 1}};
  const double focal_px = 0.5 * kSize / camera_frame(camera_).tan_half_field_of_view;
  const auto differing = [&](double px_per_cell, bool is_still) {
    look_at({34.5, 34.5, 34.5}, focal_px / px_per_cell);
    settings_.shading = Shading::exact;
    const auto exact = draw(is_still);
    settings_.shading = Shading::smooth;
    const auto smooth = draw(is_still);
    int count = 0;
    for (size_t i = 0; i < exact.size(); ++i) {
      count += exact[i].hit && angle(exact[i].normal, smooth[i].normal) > 0.05;
    }
    return count;
  };
  EXPECT_EQ(differing(2.5, false), 0);
  EXPECT_GT(differing(4.5, false), 2000);
  EXPECT_EQ(differing(0.35, true), 0);
  EXPECT_GT(differing(1.2, true), 500);
}

// The mean of still pictures begins with the picture that draw() has left: cells below 3 px become
// smooth in it as well. Then the mean of two is near that of all eight.
TEST_F(RenderSmoothGpu, FirstStillPictureIsSmooth) {
  const TestVolume volume = marschner_lobb();
  show_volume(*renderer_, volume, 5000, 5000);
  settings_.isosurfaces = {{5000, {0.8f, 0.8f, 0.8f}, 1}};
  // Occlusion and shadows differ from picture to picture.
  settings_.light.occlusion = settings_.light.shadow = 0;
  camera_.elevation = 60;
  const double focal_px = 0.5 * kSize / camera_frame(camera_).tan_half_field_of_view;
  look_at({20, 20, 20}, focal_px / 2.8);
  const auto draw_two = [&](Shading shading) {
    settings_.shading = shading;
    renderer_->set_settings(settings_);
    renderer_->set_camera(camera_);
    return refined_once();
  };
  const auto exact = draw_two(Shading::exact), smooth = draw_two(Shading::smooth);
  EXPECT_TRUE(renderer_->can_refine(kSize, kSize));
  const Image all = draw_image(*renderer_, kSize, kSize, nullptr, true).value();
  const auto pixels = renderer_->read_surface().value();
  const auto difference = [&](const std::vector<uint8_t>& two) {
    double sum = 0, count = 0;
    for (size_t y = 1; y + 1 < kSize; ++y) {
      for (size_t x = 1; x + 1 < kSize; ++x) {
        const auto is_beside = [&](size_t i) {
          return pixels[i].hit && std::abs(pixels[i].depth - pixels[y * kSize + x].depth) < 1;
        };
        const size_t i = y * kSize + x;
        if (!is_beside(i) || !is_beside(i - 1) || !is_beside(i + 1) || !is_beside(i - kSize) ||
            !is_beside(i + kSize)) {
          continue;  // edges differ as well
        }
        sum += std::abs(two[4 * i] - all.at(int(x), int(kSize - 1 - y))[0]);
        ++count;
      }
    }
    EXPECT_GT(count, 2000);
    return sum / count;
  };
  EXPECT_LT(difference(smooth), 0.2 * difference(exact));
}

// A coarse chunk with larger cells is hidden directly behind fine cells below 3 px. It does not
// change the picture: the normals stay those of the fine cells. There is no threshold, since the
// pictures must be equal.
TEST_F(RenderSmoothGpu, HiddenCoarseCellsLeaveSmallFineCellsTheirNormals) {
  // Two sheets, at y = 63.4 and behind it at y = 64.6, in two blocks.
  const TestVolume volume = sampled_volume(
      {65, 129, 65}, {1, 1, 1}, [](Vec3d p) { return 500 * std::abs(p.y - 64) + 4 * p.x; });
  renderer_->set_volume(volume.grid, volume.mapping);
  const BlockKey fine{0, {0, 0, 0}}, coarse{1, {0, 0, 0}};
  ASSERT_TRUE(renderer_->add_chunk(0, fine, block_samples(volume, fine, 400, 400)));
  ASSERT_TRUE(renderer_->add_chunk(1, coarse, block_samples(volume, coarse, 400, 400)));
  RegionMask behind;
  for (int z = 0; z < 8; ++z) {
    for (int x = 0; x < 8; ++x) behind.insert({x, 4, z});  // coarse cells of y = 64 to 80
  }
  settings_.isosurfaces = {{400, {1, 1, 1}, 1}};
  camera_.elevation = 0;
  camera_.azimuth = 0;
  const double focal_px = 0.5 * kSize / camera_frame(camera_).tan_half_field_of_view;
  look_at({32, 63.4, 32}, focal_px / 2.2);
  const DrawnChunk front[] = {{0}}, both[] = {{0}, {1, behind}}, back[] = {{1, behind}};
  renderer_->set_visible(back);
  const auto alone = draw();
  EXPECT_GT(std::count_if(alone.begin(), alone.end(), [](const Pixel& p) { return p.hit; }), 10000);
  renderer_->set_visible(front);
  const auto expected = draw();
  renderer_->set_visible(both);
  const auto found = draw();
  int hits = 0;
  for (size_t i = 0; i < found.size(); ++i) {
    ASSERT_EQ(found[i].hit, expected[i].hit);
    if (!found[i].hit) continue;
    ++hits;
    ASSERT_EQ(found[i].depth, expected[i].depth);
    ASSERT_EQ(angle(found[i].normal, expected[i].normal), 0) << i;
  }
  EXPECT_GT(hits, 10000);
}

TEST_F(RenderSmoothGpu, PointsAndTrianglesAreTheSame) {
  const TestVolume volume = sphere_volume({70, 70, 70});
  settings_.isosurfaces = {{2500, {1, 1, 1}, 1}};
  look_at({34.5, 34.5 - 25, 34.5}, 12);
  std::vector<Pixel> pixels[2];
  for (const float max_point_size : {1024.0f, 8.0f}) {
    renderer_ = std::move(*Renderer::create(max_point_size));
    show_volume(*renderer_, volume, 2500, 2500);
    pixels[max_point_size == 8] = draw();
  }
  int hits = 0, differing = 0;
  for (size_t i = 0; i < pixels[0].size(); ++i) {
    if (!pixels[0][i].hit || !pixels[1][i].hit) continue;
    ++hits;
    differing += angle(pixels[0][i].normal, pixels[1][i].normal) > 0.05;
  }
  EXPECT_GT(hits, 20000);
  EXPECT_LE(differing, hits / 1000);
}

}  // namespace
}  // namespace isosplat::render
