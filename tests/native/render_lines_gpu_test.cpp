// Contour lines of a field, compared with the field at the position of each pixel: between two
// pixels whose values have a multiple of the interval between them there is a line, and nowhere
// else.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tests/native/lines_renderer_test.h"

namespace isosplat::render {
namespace {

TEST_F(LinesGpu, AreWhereTheFieldIsAMultipleOfTheInterval) {
  for (const uint32_t level : {0u, 1u}) {
    for (const bool orthographic : {false, true}) {
      for (const double distance : {1.0, 0.35}) {
        show(ball(), pressures(), level);
        camera_ = default_camera(volume_.grid, 1, orthographic);
        camera_.azimuth = 25;
        camera_.elevation = 20;
        camera_.distance *= distance;
        settings_.field_lines = distance < 1 ? 15 : 40;
        const auto numbers = expected(linear);
        for (const SplatKind kind : {SplatKind::exact, SplatKind::ellipse, SplatKind::quad}) {
          for (const Shading shading : {Shading::smooth, Shading::exact}) {
            settings_.kind = kind;
            settings_.shading = shading;
            const std::string name = "lines-" + std::to_string(level) +
                                     std::to_string(orthographic) +
                                     std::to_string(int(10 * distance)) + "-" +
                                     std::to_string(int(kind)) + std::to_string(int(shading));
            const Comparison c = compare_lines(numbers, drawn(name));
            EXPECT_GT(c.lines, distance < 1 ? 2000 : 200) << name;
            EXPECT_GT(c.marked, distance < 1 ? 2000 : 200) << name;
            // Lines are wider where the field has an extremum. Squares are not exactly where the
            // surface is.
            const double share = kind == SplatKind::quad ? 0.04 : 0.02;
            EXPECT_LE(c.unmarked, share * c.lines) << name << ' ' << c.lines;
            EXPECT_LE(c.false_ones, share * c.marked) << name << ' ' << c.marked;
          }
        }
      }
    }
  }
}

TEST_F(LinesGpu, AreTheSameOnShearedGridsWithClippingAndTextures) {
  renderer_ = std::move(*Renderer::create(/*max_point_size=*/4));
  settings_.field_lines = 40;
  VolumeGrid grid{{49, 49, 49}, {1, 1.25, 0.8}};
  grid.direction = {1, 0.6, 0, 0, 0.8, 0, 0, 0, 1};
  TestVolume volume = ball(), field = pressures();
  volume.grid = field.grid = grid;
  show(volume, field);
  settings_.clip_box_high.x = 0.6;
  const auto numbers = expected(linear);
  for (const SplatKind kind : {SplatKind::exact, SplatKind::ellipse, SplatKind::quad}) {
    settings_.kind = kind;
    const Comparison c = compare_lines(numbers, drawn("lines-sheared"));
    EXPECT_GT(c.lines, 100);
    const double share = kind == SplatKind::quad ? 0.05 : 0.015;
    EXPECT_LE(c.unmarked, share * c.lines) << int(kind) << ' ' << c.lines;
    EXPECT_LE(c.false_ones, share * c.marked) << int(kind) << ' ' << c.marked;
  }
}

TEST_F(LinesGpu, AreAtEqualStepsOfTheLogarithm) {
  settings_.field_scale = FieldScale::logarithmic;
  settings_.colour_low = 10;
  settings_.colour_high = 150;
  settings_.field_lines = 0.1;
  show(ball(), pressures());
  camera_.distance *= 0.5;
  const auto numbers = expected(decades);
  for (const SplatKind kind : {SplatKind::exact, SplatKind::ellipse, SplatKind::quad}) {
    settings_.kind = kind;
    const Comparison c = compare_lines(numbers, drawn("lines-decades"));
    EXPECT_GT(c.lines, 500);
    const double share = kind == SplatKind::quad ? 0.05 : 0.015;
    EXPECT_LE(c.unmarked, share * c.lines) << int(kind) << ' ' << c.lines;
    EXPECT_LE(c.false_ones, share * c.marked) << int(kind) << ' ' << c.marked;
  }
}

TEST_F(LinesGpu, AreInStillPicturesAndWithStepsAndTranslucency) {
  settings_.field_lines = 15;
  show(ball(), pressures());
  camera_.distance *= 0.5;
  const auto numbers = expected(linear);
  settings_.kind = SplatKind::exact;
  for (const float opacity : {1.0f, 0.6f}) {
    settings_.isosurfaces.front().opacity = opacity;
    settings_.field_steps = 6;
    // The mean of shifted pictures is paler than one picture with a line in the middle of a pixel.
    const auto change = drawn("lines-still", /*still=*/true);
    const Comparison c = compare_lines(numbers, change, /*reach=*/2, 0.35 * opacity * opacity);
    EXPECT_GT(c.lines, 500);
    EXPECT_GT(c.marked, 500) << opacity;
    EXPECT_LE(c.false_ones, 0.02 * c.marked) << opacity;
    if (opacity == 1) {
      EXPECT_LE(c.unmarked, 0.01 * c.lines);
    }
  }
}

TEST_F(LinesGpu, FadeWhereTheyAreDense) {
  show(ball(), pressures());
  for (const SplatKind kind : {SplatKind::exact, SplatKind::ellipse, SplatKind::quad}) {
    settings_.kind = kind;
    settings_.field_lines = 15;
    const auto numbers = expected(linear);
    settings_.field_lines = 15.0 / 16;
    const auto change = drawn("lines-dense");
    int dense = 0, changed = 0;
    for (int y = 2; y < kSize - 2; ++y) {
      for (int x = 2; x < kSize - 2; ++x) {
        // Closer than 2 px: a line of 15/16 for each 16th of a line of 15. Along both axes
        // together.
        const size_t at = size_t(y * kSize + x);
        const double right = 16 * (numbers[at + 1] - numbers[at - 1]) / 2;
        const double up = 16 * (numbers[at + kSize] - numbers[at - kSize]) / 2;
        if (!(std::hypot(right, up) > 0.5)) continue;
        ++dense;
        changed += change[at] > 0.1;
      }
    }
    EXPECT_GT(dense, 1000);
    // At most some pixels of squares, and beside an outline.
    EXPECT_LE(changed, 0.01 * dense) << int(kind);
  }
}

TEST_F(LinesGpu, AreMissingWithTheValuesAndWhereValuesAreEqual) {
  mapping_.has_missing = true;
  TestVolume field = pressures();
  for (size_t i = 0; i < field.quantized_values.size(); ++i) {
    // Missing for x < 24, and the same value, that of a line, above z = 24.
    if (i / (49 * 49) > 24) field.quantized_values[i] = 33000;
    if (i % 49 < 24) field.quantized_values[i] = kMissingVoxel;
  }
  settings_.field_lines = 15;
  ASSERT_EQ(mapping_.value(33000), 30);
  for (const SplatKind kind : {SplatKind::quad, SplatKind::ellipse, SplatKind::exact}) {
    settings_.kind = kind;
    show(ball(), field);
    camera_.azimuth = 10;
    const auto change = drawn("lines-missing");
    draw("lines-missing");
    const auto all = pixels();
    int missing = 0, equal = 0, marked = 0, others = 0;
    for (size_t i = 0; i < all.size(); ++i) {
      if (!all[i].hit) continue;
      const Vec3d at = voxel_at(i, double(all[i].depth));
      const bool is_missing = all[i].field == Field::missing, is_equal = at.z > 27;
      missing += is_missing;
      equal += is_equal && !is_missing;
      if (is_missing || is_equal)
        marked += change[i] > 0.05;
      else
        others += change[i] > 0.35;
    }
    EXPECT_GT(missing, 4000);
    EXPECT_GT(equal, 1000);
    EXPECT_GT(others, 100);
    EXPECT_LE(marked, kind == SplatKind::quad ? 10 : 0) << int(kind);
  }
}

}  // namespace
}  // namespace isosplat::render
