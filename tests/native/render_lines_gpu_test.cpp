// Contour lines of a field, compared with the field at the position of each pixel: between two
// pixels whose values have a multiple of the interval between them there is a line, and nowhere
// else.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "shared/render/passes/line_weights.h"
#include "shared/render/settings/colour_maps.h"
#include "shared/render/settings/light.h"
#include "tests/native/field_renderer_test.h"

namespace isosplat::render {
namespace {

class LinesGpu : public FieldRendererTest {
 protected:
  using Number = double (*)(double value, double interval);
  static double linear(double value, double interval) { return value / interval; }
  static double decades(double value, double interval) { return std::log10(value) / interval; }

  /// Where lines should be: the number of lines below the value at each pixel, of pictures with the
  /// first row below. NaN where no surface or no value is.
  std::vector<double> expected(Number number) {
    RenderSettings exact = settings_;
    exact.kind = SplatKind::exact;
    exact.field_lines = 0;
    draw_and_keep(exact, camera_, kSize, "lines-positions");
    const auto all = pixels();
    std::vector<double> numbers(all.size(), std::numeric_limits<double>::quiet_NaN());
    for (size_t i = 0; i < all.size(); ++i) {
      if (!all[i].hit || all[i].field != Field::value) continue;
      const double value = mapping_.value(field_at(voxel_at(i, double(all[i].depth))));
      numbers[i] = number(value, settings_.field_lines);
    }
    return numbers;
  }

  /// The change of each pixel by the lines, from 0 to 1: of the largest channel of either picture.
  std::vector<double> drawn(const std::string& name, bool still = false) {
    RenderSettings plain = settings_;
    plain.field_lines = 0;
    const Image without = draw_and_keep(plain, camera_, kSize, "lines-without", still);
    const Image with = draw(name, still);
    std::vector<double> change(size_t{kSize} * kSize);
    for (size_t i = 0; i < change.size(); ++i) {
      const size_t at = 4 * ((kSize - 1 - i / kSize) * kSize + i % kSize);
      for (size_t c = 0; c < 3; ++c) {
        const double a = with.rgba[at + c], b = without.rgba[at + c];
        change[i] = std::max(change[i], std::abs(a - b) / std::max({a, b, 1.0}));
      }
    }
    return change;
  }

  struct Comparison {
    int lines = 0;       ///< pairs of neighbours with a line between them
    int unmarked = 0;    ///< of these: neither pixel has changed
    int marked = 0;      ///< pixels that have changed strongly
    int false_ones = 0;  ///< of these: without a line nearby
  };

  /// Where lines are at least 6 px from each other, and at least 2 px from an outline.
  static Comparison compare_lines(const std::vector<double>& numbers,
                                  const std::vector<double>& change, int reach = 1) {
    Comparison c;
    for (int y = 3; y < kSize - 3; ++y) {
      for (int x = 3; x < kSize - 3; ++x) {
        const auto at = [&](int right, int up) { return size_t((y + up) * kSize + x + right); };
        double least = numbers[at(0, 0)], most = least, widest = 0;
        bool is_whole = true, is_near = false;
        for (int up = -2; up <= 2; ++up) {
          for (int right = -2; right <= 2; ++right) {
            const double here = numbers[at(right, up)];
            is_whole = is_whole && !std::isnan(here);
            if (std::isnan(here)) continue;
            least = std::min(least, here);
            most = std::max(most, here);
          }
        }
        widest = (most - least) / 4;
        if (!is_whole || widest > 1.0 / 6) continue;
        const auto line_of = [&](int right, int up) { return std::floor(numbers[at(right, up)]); };
        for (int up = -reach; up <= reach; ++up) {
          for (int right = -reach; right <= reach; ++right) {
            is_near = is_near || line_of(right, up) != line_of(0, 0);
          }
        }
        if (change[at(0, 0)] > 0.35) {
          ++c.marked;
          c.false_ones += !is_near;
        }
        for (const auto& [right, up] : {std::pair{1, 0}, std::pair{0, 1}}) {
          if (line_of(0, 0) == line_of(right, up)) continue;
          ++c.lines;
          c.unmarked += std::max(change[at(0, 0)], change[at(right, up)]) < 0.3;
        }
      }
    }
    return c;
  }
};

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
    const Comparison c = compare_lines(numbers, change, /*reach=*/2);
    EXPECT_GT(c.lines, 500);
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
    // Missing for x < 24, and the same value, that of a line, above y = 24.
    if (i / 49 % 49 > 24) field.quantized_values[i] = 33000;
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
      const bool is_missing = all[i].field == Field::missing, is_equal = at.y > 27;
      missing += is_missing;
      equal += is_equal && !is_missing;
      if (is_missing || is_equal)
        marked += change[i] > 0.05;
      else
        others += change[i] > 0.35;
    }
    EXPECT_GT(missing, 4000);
    EXPECT_GT(equal + others, 100);
    EXPECT_GT(others, 100);
    EXPECT_LE(marked, kind == SplatKind::quad ? 10 : 0) << int(kind);
  }
}

TEST_F(LinesGpu, IntervalsThatAreNoneDrawNothing) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (const SplatKind kind : {SplatKind::quad, SplatKind::ellipse, SplatKind::exact}) {
    settings_.kind = kind;
    show(ball(), pressures());
    settings_.field_lines = 0;
    const Image plain = draw("lines-none");
    for (const double interval : {-1.0, std::nan(""), kInfinity, -kInfinity}) {
      settings_.field_lines = interval;
      EXPECT_EQ(draw("lines-none").rgba, plain.rgba) << interval;
    }
    for (const FieldScale scale : {FieldScale::linear, FieldScale::logarithmic}) {
      settings_.field_scale = scale;
      settings_.field_lines = 0;
      const Image other = draw("lines-none");
      for (const double interval : {5e-324, 1e-300, 1e-9, 1e9, 1e300}) {
        settings_.field_lines = interval;
        const Image image = draw("lines-far");
        int most = 0;
        for (size_t i = 0; i < image.rgba.size(); ++i) {
          most = std::max(most, std::abs(int(image.rgba[i]) - int(other.rgba[i])));
        }
        // A huge interval has a line at 0, on the side of the ball; and at 1 with a logarithm.
        if (interval < 1) {
          EXPECT_LE(most, 2) << interval;
        }
      }
    }
    settings_.field_scale = FieldScale::linear;
  }
}

TEST_F(LinesGpu, ContrastWithEachColourOfEachMap) {
  for (int map = 0; map < kColourMaps; ++map) {
    settings_.colour_map = static_cast<ColourMap>(map);
    settings_.field_lines = 1;
    const auto [from, to] = std::array{line_weights(settings_, mapping_).tones[1],
                                       line_weights(settings_, mapping_).tones[2]};
    for (int i = 0; i < 256; ++i) {
      const auto* c = kColourMapTable[map][i];
      const double luminance = 0.2126 * double(srgb_to_linear(float(c[0]) / 255)) +
                               0.7152 * double(srgb_to_linear(float(c[1]) / 255)) +
                               0.0722 * double(srgb_to_linear(float(c[2]) / 255));
      const bool is_dark = float(i) / 255 >= from && float(i) / 255 <= to;
      // The contrast ratio of WCAG 2: 4.5 is that of legible text.
      const double contrast = is_dark ? (luminance + 0.05) / 0.05 : 1.05 / (luminance + 0.05);
      EXPECT_GT(contrast, 4.5) << map << ' ' << i;
    }
  }
}

}  // namespace
}  // namespace isosplat::render
