// Contour lines where there are none or few: intervals that are too large or too small, fields that
// are constant on the surface; and their contrast with the colours.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "shared/render/passes/line_weights.h"
#include "shared/render/settings/colour_maps.h"
#include "shared/render/settings/light.h"
#include "tests/native/lines_renderer_test.h"

namespace isosplat::render {
namespace {

/// Pixels that may differ since programs with lines round otherwise, and a fragment is missing.
constexpr int kFewest = 2;

/// The relative luminance of a colour map, whose linear colours are interpolated.
double luminance(int map, double position) {
  const double at = std::clamp(255 * position, 0.0, 255.0);
  const int below = std::min(int(at), 254);
  const auto of = [&](int i) {
    const auto* c = kColourMapTable[map][i];
    return 0.2126 * double(srgb_to_linear(float(c[0]) / 255)) +
           0.7152 * double(srgb_to_linear(float(c[1]) / 255)) +
           0.0722 * double(srgb_to_linear(float(c[2]) / 255));
  };
  return of(below) + (at - below) * (of(below + 1) - of(below));
}

/// The contrast ratio of WCAG 2.
double contrast(double bright, double dark) {
  return (bright + 0.05) / (dark + 0.05);
}

/// Whether black contrasts more than white.
bool is_bright(double luminance) {
  return contrast(luminance, 0) >= contrast(1, luminance);
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
      for (const double interval : {5e-324, 1e-300, 1e-9}) {
        settings_.field_lines = interval;
        EXPECT_LE(count_changed(drawn("lines-far")), kFewest) << interval;
      }
    }
    settings_.field_scale = FieldScale::linear;
  }
}

TEST_F(LinesGpu, HugeIntervalsHaveTheLineOfZeroAlone) {
  for (const SplatKind kind : {SplatKind::quad, SplatKind::ellipse, SplatKind::exact}) {
    settings_.kind = kind;
    // A line at 0, on the side of the ball; and at 1 with a logarithm.
    for (const FieldScale scale : {FieldScale::linear, FieldScale::logarithmic}) {
      show(ball(), pressures());
      camera_.distance *= 0.5;
      settings_.field_scale = scale;
      settings_.colour_low = scale == FieldScale::linear ? -100 : 0.1;
      settings_.colour_high = scale == FieldScale::linear ? 140 : 100;
      settings_.field_lines = 1e9;
      const auto change = drawn("lines-far");
      const auto sides =
          expected(scale == FieldScale::linear ? linear : [](double value, double interval) {
            return decades(std::max(value, 1e-9), interval);
          });
      const Beside c = beside_lines(sides, change);
      EXPECT_GT(c.near, 100) << int(kind) << int(scale);
      EXPECT_LE(c.far, 0.02 * c.near) << int(kind) << int(scale);
      settings_.field_lines = 1e300;
      EXPECT_LE(count_changed(drawn("lines-farther")), kFewest) << int(kind);
    }
    // No line in the range, and one near to it: a number of lines that floats cannot tell from a
    // line.
    settings_.field_lines = 1e9;
    settings_.colour_low = 0.1;
    settings_.colour_high = 0.9;
    mapping_.offset = 0.1;
    mapping_.scale = 1e-5;
    show(ball(), pressures());
    EXPECT_LE(count_changed(drawn("lines-decades-far")), kFewest) << int(kind);
    settings_.field_scale = FieldScale::linear;
    mapping_.offset = 999999990;
    mapping_.scale = 1e-4;
    settings_.colour_low = mapping_.value(20000);
    settings_.colour_high = mapping_.value(44000);
    show(ball(), pressures());
    EXPECT_LE(count_changed(drawn("lines-offset-far")), kFewest) << int(kind);
    mapping_.offset = -300;
    mapping_.scale = 0.01;
  }
}

// A field that is constant on the surface has no line there, though it is everywhere a multiple of
// the interval but for rounding.
TEST_F(LinesGpu, AreMissingWhereTheFieldIsConstantOnTheSurface) {
  for (const bool rounded : {false, true}) {
    // Rounding turns gradients more where they are much smaller than the cell's span.
    const double steepness = rounded ? 6 : 1;
    const int most = rounded ? 50 : kFewest;
    const TestVolume volume = sampled_volume({49, 49, 49}, {1, 1, 1}, [&](Vec3d p) {
      return std::clamp(kIsovalue + steepness * (bumpy(p) - kIsovalue), 0.0, 65000.0);
    });
    for (const double distance : {1.0, 0.4, 0.1}) {
      show(volume, volume);
      camera_.distance *= distance;
      const double value = mapping_.value(kIsovalue);
      settings_.colour_low = value - 10 * steepness;
      settings_.colour_high = value + 10 * steepness;
      settings_.field_lines = 6 * steepness;
      mapping_.offset = -18;
      for (const SplatKind kind : {SplatKind::quad, SplatKind::ellipse, SplatKind::exact}) {
        settings_.kind = kind;
        for (const Shading shading : {Shading::smooth, Shading::exact}) {
          settings_.shading = shading;
          EXPECT_LE(count_changed(drawn("lines-constant")), most)
              << steepness << ' ' << distance << ' ' << int(kind) << int(shading);
        }
      }
    }
  }
}

// With colour steps, a line contrasts with the colour of its step, not with the one that the whole
// map has there; on the border of two steps, with the higher one.
TEST_F(LinesGpu, ContrastWithTheColoursOfSteps) {
  settings_.kind = SplatKind::exact;
  settings_.colour_low = -100;
  settings_.colour_high = 140;
  for (int map = 0; map < kColourMaps; ++map) {
    settings_.colour_map = static_cast<ColourMap>(map);
    for (int steps = 2; steps <= 12; ++steps) {
      settings_.field_steps = steps;
      for (const bool on_borders : {false, true}) {
        if (on_borders && 12 % steps != 0) continue;
        settings_.field_lines = on_borders ? 20 : 17;
        show(ball(), pressures());
        camera_.distance *= 0.6;
        int right = 0, wrong = 0;
        const auto change = signed_change("lines-steps");
        const auto all = pixels();
        const int reach = on_borders ? 1 : 2;
        for (int y = reach; y < kSize - reach; ++y) {
          for (int x = reach; x < kSize - reach; ++x) {
            const size_t i = size_t(y * kSize + x);
            if (std::abs(change[i]) < 0.35) continue;
            int lowest = steps, highest = -1;
            for (int up = -reach; up <= reach; ++up) {
              for (int aside = -reach; aside <= reach; ++aside) {
                const SurfacePixel& pixel = all[size_t((y + up) * kSize + x + aside)];
                const int step = pixel.hit ? int(pixel.scalar * float(steps)) : -1;
                lowest = std::min(lowest, step);
                highest = std::max(highest, step);
              }
            }
            if (lowest < 0 || (!on_borders && lowest != highest)) continue;
            const bool should_be_dark = is_bright(luminance(map, highest / (steps - 1.0)));
            ++(should_be_dark == (change[i] < 0) ? right : wrong);
          }
        }
        EXPECT_GT(right, 300) << map << ' ' << steps << on_borders;
        EXPECT_LE(wrong, 0.02 * right) << map << ' ' << steps << on_borders;
      }
    }
  }
}

TEST_F(LinesGpu, ContrastWithEachColourOfEachMap) {
  for (int map = 0; map < kColourMaps; ++map) {
    settings_.colour_map = static_cast<ColourMap>(map);
    settings_.field_lines = 1;
    const auto tones = line_weights(settings_, mapping_).tones;
    for (int i = 0; i <= 2550; ++i) {
      const double y = luminance(map, i / 2550.0);
      const bool is_dark = float(i) / 2550 >= tones[1] && float(i) / 2550 <= tones[2];
      // 4.5 is that of legible text.
      EXPECT_GT(is_dark ? contrast(y, 0) : contrast(1, y), 4.5) << map << ' ' << i;
    }
  }
}

}  // namespace
}  // namespace isosplat::render
