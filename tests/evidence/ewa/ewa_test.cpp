// Tests the EWA resampling filter against its equations, and the measures of alias and blur on
// pictures whose alias and blur are known.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>

#include "native/headless/ray_caster.h"
#include "tests/evidence/ewa/contrast.h"
#include "tests/evidence/ewa/ewa_filter.h"
#include "tests/evidence/ewa/spectrum.h"

namespace isosplat {
namespace {

constexpr Vec3f kColour{0.25f, 0.5f, 0.75f};

/// A camera in front of the plane z = 0, or at an angle to it.
render::Camera camera_at(double elevation, double distance = 100) {
  render::Camera camera;
  camera.azimuth = 25;
  camera.elevation = elevation;
  camera.distance = distance;
  return camera;
}

/// Surfels of the plane z = `z`, on a square lattice with distance 1.
template <class Colour>
std::vector<Surfel> plane(int half, double z, double deviation, Colour colour) {
  std::vector<Surfel> surfels;
  for (int y = -half; y <= half; ++y) {
    for (int x = -half; x <= half; ++x) {
      surfels.push_back({{double(x), double(y), z}, {0, 0, 1}, 1, deviation, colour(x, y)});
    }
  }
  return surfels;
}

Vec3f constant(int, int) {
  return kColour;
}

double difference(Vec3f a, Vec3f b) {
  return double(std::max({std::abs(a.x - b.x), std::abs(a.y - b.y), std::abs(a.z - b.z)}));
}

TEST(EwaFilter, KeepsAConstantColour) {
  const auto surfels = plane(60, 0, 0.5, constant);
  for (const double elevation : {90.0, 40.0, 10.0}) {
    for (const bool orthographic : {false, true}) {
      render::Camera camera = camera_at(elevation);
      camera.orthographic = orthographic;
      const EwaPicture picture = draw_ewa(surfels, ImagePlane(camera, 48, 48));
      for (int y = 20; y < 28; ++y) {
        for (int x = 4; x < 44; ++x) {
          const size_t i = picture.at(x, y);
          ASSERT_GT(picture.weight[i], 0.5) << elevation << ": " << x << ", " << y;
          EXPECT_LT(difference(picture.colour[i], kColour), 1e-6);
        }
      }
    }
  }
}

TEST(EwaFilter, WeightsOfAnEvenPlaneAddUpToOne) {
  // On a square lattice, the sum of Gaussians is 1 to within 4 exp(−2π² σ²): 3 % at a deviation of
  // half the distance, 0.03 % at 0.7 times.
  for (const auto& [deviation, error] : {std::pair{0.5, 0.03}, {0.7, 1e-3}}) {
    const auto surfels = plane(60, 0, deviation, constant);
    for (const double elevation : {90.0, 35.0}) {
      // Cells are as large as 8 px, so that the low-pass filter hides no error. The rays are
      // parallel, so that the affine approximation is exact.
      render::Camera camera = camera_at(elevation, 22);
      camera.orthographic = true;
      const EwaPicture picture = draw_ewa(surfels, ImagePlane(camera, 96, 96));
      for (int y = 30; y < 66; ++y) {
        for (int x = 30; x < 66; ++x) {
          EXPECT_NEAR(picture.weight[picture.at(x, y)], 1, error) << deviation;
        }
      }
    }
  }
}

TEST(EwaFilter, SplatHasTheEnergyAndVarianceOfTheory) {
  Surfel surfel{{0, 0, 0}, {0, 0, 1}, 1.7, 0.8, kColour};
  for (const double elevation : {90.0, 30.0, 8.0}) {
    // The camera is far away, so that the affine approximation is exact enough. V is then known in
    // closed form: (σ s)² + 1 across the view, and (σ s sin(elevation))² + 1 along it.
    render::Camera camera = camera_at(elevation, 400);
    camera.field_of_view = 10;
    constexpr int kSize = 256;
    const ImagePlane image(camera, kSize, kSize);
    const double scale = kSize / (2 * image.frame().half_height(400));
    const double sine = std::sin(elevation * std::numbers::pi / 180);
    const EwaPicture picture = draw_ewa(std::span(&surfel, 1), image, {.cutoff = 6});
    double sum = 0, mean_x = 0, mean_y = 0, xx = 0, xy = 0, yy = 0;
    for (int y = 0; y < kSize; ++y) {
      for (int x = 0; x < kSize; ++x) {
        const double weight = picture.weight[picture.at(x, y)];
        const double dx = x + 0.5 - 0.5 * kSize, dy = y + 0.5 - 0.5 * kSize;
        sum += weight;
        mean_x += weight * dx;
        mean_y += weight * dy;
        xx += weight * dx * dx;
        xy += weight * dx * dy;
        yy += weight * dy * dy;
      }
    }
    const double across = 0.8 * scale;
    EXPECT_NEAR(sum, 1.7 * scale * scale * sine, 1e-3 * sum) << elevation;
    EXPECT_NEAR(mean_x / sum, 0, 1e-6);
    EXPECT_NEAR(mean_y / sum, 0, 1e-6);
    EXPECT_NEAR(xx / sum, across * across + 1, 1e-3 * xx / sum);
    EXPECT_NEAR(xy / sum, 0, 1e-6);
    EXPECT_NEAR(yy / sum, across * across * sine * sine + 1, 1e-3 * yy / sum);
  }
}

TEST(EwaFilter, JacobianIsThatOfThePerspective) {
  // Compares with finite differences, far from the middle of the image.
  const ImagePlane image(camera_at(20, 30), 200, 150);
  const Vec3d at{7, -4, 1.5}, direction{0.3, -0.8, 0.4};
  constexpr double kStep = 1e-5;
  const Vec2d from = image.place(at - direction * kStep), to = image.place(at + direction * kStep);
  const Vec2d derivative = image.derivative(at, direction);
  EXPECT_NEAR(derivative.x, (to.x - from.x) / (2 * kStep), 1e-6);
  EXPECT_NEAR(derivative.y, (to.y - from.y) / (2 * kStep), 1e-6);
  EXPECT_NEAR(
      image.depth_derivative(at, direction),
      (image.depth(at + direction * kStep) - image.depth(at - direction * kStep)) / (2 * kStep),
      1e-9);
}

TEST(EwaFilter, MinifiedCheckerIsMidGrey) {
  const auto surfels = plane(300, 0, 0.5, [](int x, int y) {
    return (((x + 300) / 2 + (y + 300) / 2) % 2) ? Vec3f{1, 1, 1} : Vec3f{0, 0, 0};
  });
  // A square of the pattern covers 0.8 px: its lowest waves have 0.9 cycles per px.
  render::Camera camera = camera_at(90);
  camera.orthographic = true;
  camera.azimuth = 0;
  camera.distance = 80 / render::camera_frame(camera).tan_half_field_of_view;
  const EwaPicture picture = draw_ewa(surfels, ImagePlane(camera, 64, 64));
  for (const Vec3f colour : picture.colour) EXPECT_NEAR(colour.x, 0.5, 0.01);
}

TEST(EwaFilter, BlendsWhatIsVisibleOnly) {
  const auto white = [](int, int) { return Vec3f{1, 1, 1}; };
  const auto black = [](int, int) { return Vec3f{}; };
  for (const auto& [behind, least, most] : {std::tuple{3.0, 1.0, 1.0}, {0.5, 0.4, 0.6}}) {
    auto surfels = plane(40, 0, 0.5, white);
    const auto others = plane(40, -behind, 0.5, black);
    surfels.insert(surfels.end(), others.begin(), others.end());
    const EwaPicture picture = draw_ewa(surfels, ImagePlane(camera_at(90, 60), 32, 32));
    for (const Vec3f colour : picture.colour) {
      EXPECT_GE(double(colour.x), least - 1e-6) << behind;
      EXPECT_LE(double(colour.x), most + 1e-6) << behind;
    }
  }
}

TEST(EwaFilter, CoverageAtAnOutlineIsThatOfTheLowPassFilter) {
  // For half of a plane, the coverage is a step, convolved with the kernel and the low-pass filter.
  // For a sphere, it is the disc.
  auto half = plane(60, 0, 0.5, constant);
  std::erase_if(half, [](const Surfel& surfel) { return surfel.position.x < 0; });
  render::Camera camera = camera_at(90);
  camera.orthographic = true;
  camera.azimuth = 0;
  camera.distance = 8 / render::camera_frame(camera).tan_half_field_of_view;  // 4 px per cell
  const EwaPicture edge = draw_ewa(half, ImagePlane(camera, 64, 64));
  const double deviation = std::sqrt(0.5 * 0.5 * 16 + 1);
  for (int x = 16; x < 48; ++x) {
    const double px = x + 0.5 - (32 - 2);  // the first surfels represent the part from x = −½ on
    EXPECT_NEAR(edge.coverage[edge.at(x, 32)],
                0.5 * std::erfc(-px / (std::numbers::sqrt2 * deviation)), 0.05)
        << x;
  }

  const TestVolume volume = sphere_volume({41, 41, 41});
  const auto sphere = surfels_of(volume, 1500, 0.5, [](Vec3d, Vec3d) { return kColour; });
  camera.target = {20, 20, 20};
  camera.distance = 20 / render::camera_frame(camera).tan_half_field_of_view;
  const EwaPicture disc = draw_ewa(sphere, ImagePlane(camera, 40, 40));  // 1 px per cell
  double area = 0;
  for (const double coverage : disc.coverage) area += coverage;
  EXPECT_NEAR(area, std::numbers::pi * 225, 0.02 * area);
  EXPECT_GT(disc.coverage[disc.at(20, 20)], 0.9);
}

TEST(EwaFilter, SurfelsBehindTheEyeOrSeenFromTheSideHaveNoSplat) {
  const ImagePlane image(camera_at(0), 32, 32);
  const Vec3d behind = image.frame().eye - image.frame().forward;
  EXPECT_FALSE(project_surfel({behind, image.frame().forward, 1, 1, {}}, image, 1));
  EXPECT_FALSE(project_surfel({{0, 0, 0}, {0, 0, 1}, 1, 1, {}}, image, 1));
  EXPECT_TRUE(project_surfel({{0, 0, 0}, image.frame().forward, 1, 1, {}}, image, 1));
}

TEST(Checker, IsAPlaneWhoseGradientHasThePattern) {
  const Checker checker(24, 4);
  const RayCaster caster(checker.volume.grid, checker.volume.quantized_values, false);
  render::Camera camera;
  camera.target = {12, 12, checker.plane()};
  camera.distance = 40;
  camera.elevation = 40;
  const ImagePlane image(camera, 64, 64);
  for (int y = 16; y < 48; y += 3) {
    for (int x = 16; x < 48; x += 3) {
      const auto hit = caster.cast(camera, 64, 64, x, 63 - y, Checker::kIsovalue);
      const auto point = checker.point_at(image, {x + 0.5, y + 0.5});
      ASSERT_TRUE(hit && point);
      EXPECT_NEAR(hit->depth, dot(*point - image.frame().eye, image.frame().forward), 1e-6);
      const auto g = [&](int i, int j) {
        return (i / 4 + j / 4) % 2 ? Checker::kHigh : Checker::kLow;
      };
      const int i = static_cast<int>(point->x), j = static_cast<int>(point->y);
      const double s = point->x - i, t = point->y - j;
      EXPECT_NEAR(hit->gradient,
                  (1 - t) * ((1 - s) * g(i, j) + s * g(i + 1, j)) +
                      t * ((1 - s) * g(i, j + 1) + s * g(i + 1, j + 1)),
                  1e-3);
    }
  }
}

TEST(Contrast, IsThatOfAKnownBlur) {
  // Pictures of the wave of order (1, 1) itself, attenuated, around the mean.
  const Checker checker(400, 4);
  render::Camera camera;
  camera.target = {200, 200, checker.plane()};
  camera.distance = 150;
  camera.elevation = 25;
  constexpr int kSize = 128;
  const ImagePlane image(camera, kSize, kSize);
  const CheckerLevels levels = levels_of(checker, camera);
  EXPECT_LT(levels.dark, levels.mean);
  EXPECT_LT(levels.mean, levels.bright);
  const auto waves = [&](double amplitude) {
    Luminance picture{kSize, kSize, {}};
    for (int y = 0; y < kSize; ++y) {
      for (int x = 0; x < kSize; ++x) {
        const auto point = checker.point_at(image, {x + 0.5, y + 0.5});
        const double phase = point ? checker.phase(*point, 1, 1) : 0;
        picture.value.push_back(levels.mean + amplitude * std::cos(2 * std::numbers::pi * phase));
      }
    }
    return picture;
  };
  const auto amplitude = [&](double of) {
    return wave_amplitude(waves(of), 1, checker, image, levels, 0.05, 0.3);
  };
  EXPECT_GT(amplitude(0.2), 0.02);
  EXPECT_NEAR(amplitude(0.05) / amplitude(0.2), 0.25, 1e-9);
}

TEST(Contrast, AliasIsWhatDiffersFromTheMeanWhereNothingCanBeSeen) {
  const Checker checker(1024, 4);
  render::Camera camera;
  camera.azimuth = 30;
  camera.elevation = 16;
  camera.field_of_view = 40;
  camera.distance = 145;
  camera.target = {700, 120, checker.plane()};
  constexpr int kSize = 128;
  const ImagePlane image(camera, kSize, kSize);
  const CheckerLevels levels = levels_of(checker, camera);
  const double half = 0.5 * (levels.bright - levels.dark);
  Luminance picture{kSize, kSize, std::vector<double>(kSize * kSize, levels.mean)};
  size_t pixels = 0;
  EXPECT_NEAR(checker_alias(picture, checker, image, levels, &pixels), 0, 1e-12);
  EXPECT_GT(pixels, 200u);
  EXPECT_LT(pixels, size_t(kSize * kSize / 2));
  for (double& value : picture.value) value = levels.mean + 0.3 * half;
  EXPECT_NEAR(checker_alias(picture, checker, image, levels), 0.3, 1e-9);
}

TEST(Contrast, EdgeWidthIsThatOfAKnownRamp) {
  const Checker checker(64, 8);
  render::Camera camera;
  camera.orthographic = true;
  camera.azimuth = 0;
  camera.elevation = 90;
  camera.roll = 10;
  camera.target = {32, 32, checker.plane()};
  constexpr int kSize = 256;
  camera.distance = 16 / render::camera_frame(camera).tan_half_field_of_view;  // 8 px per cell
  const ImagePlane image(camera, kSize, kSize);
  const CheckerLevels levels = levels_of(checker, camera);
  for (const double width_px : {4.0, 12.0}) {
    // Squares whose edges are linear ramps.
    const auto wave = [&](double at) {
      const double s = (at + 0.5) / 8, edge = std::round(s);
      const double ramp = std::clamp((s - edge) * 64 / width_px, -0.5, 0.5);
      return 2 * ramp * (static_cast<int>(edge) % 2 ? 1 : -1);
    };
    Luminance picture{kSize, kSize, {}};
    for (int y = 0; y < kSize; ++y) {
      for (int x = 0; x < kSize; ++x) {
        const auto point = checker.point_at(image, {x + 0.5, y + 0.5});
        const double bright = 0.5 - 0.5 * wave(point->x) * wave(point->y);
        picture.value.push_back(levels.dark + bright * (levels.bright - levels.dark));
      }
    }
    EXPECT_NEAR(edge_width(picture, 1, checker, image, levels), 0.8 * width_px, 0.15);
  }
}

TEST(Spectrum, FourierFindsWaves) {
  std::vector<std::complex<double>> values(64);
  for (size_t i = 0; i < 64; ++i) {
    values[i] = 3 + std::cos(2 * std::numbers::pi * 5 * double(i) / 64);
  }
  fourier(values);
  for (size_t i = 0; i < 64; ++i) {
    EXPECT_NEAR(std::abs(values[i]), i == 0 ? 192 : i == 5 || i == 59 ? 32 : 0, 1e-9) << i;
  }
}

TEST(Spectrum, AliasAndContrastAreThoseOfKnownWaves) {
  // Waves of 0.2, 0.3 and 0.9 cycles per px, drawn at 4 × 4 positions in each of 64 × 64 px.
  const auto drawn = [](double first, double second, double beyond) {
    std::vector<Luminance> pictures;
    for (int place = 0; place < 16; ++place) {
      Luminance picture{64, 64, {}};
      for (int y = 0; y < 64; ++y) {
        for (int x = 0; x < 64; ++x) {
          const double u = x + (place % 4 + 0.5) / 4, v = y + (place / 4 + 0.5) / 4;
          const auto wave = [](double cycles) { return std::cos(2 * std::numbers::pi * cycles); };
          picture.value.push_back(0.5 + first * wave(0.2 * u) + second * wave(0.3 * v) +
                                  beyond * wave(0.9 * u));
        }
      }
      pictures.push_back(picture);
    }
    return Spectrum(interleaved(pictures, 4), 4);
  };
  const Spectrum truth = drawn(0.1, 0.1, 0.05), blurred = drawn(0.06, 0.02, 0.01);
  // The windows of waves overlap a little.
  EXPECT_NEAR(blurred.contrast(truth, 0.15, 0.25), 0.6, 0.005);
  EXPECT_NEAR(blurred.contrast(truth, 0.25, 0.35), 0.2, 0.005);
  EXPECT_NEAR(truth.contrast(truth, 0.15, 0.25), 1, 1e-12);
  EXPECT_NEAR(truth.alias(truth), 0.05 / std::sqrt(0.02), 0.002);
  EXPECT_NEAR(blurred.alias(truth), 0.01 / std::sqrt(0.02), 0.002);
}

TEST(Surfels, OfASphereHaveItsNormalsAndArea) {
  const TestVolume volume = sphere_volume({41, 41, 41});
  const auto surfels = surfels_of(volume, 1500, 0.5, [](Vec3d, Vec3d) { return kColour; });
  const Vec3d centre{20, 20, 20};
  double area = 0;
  for (const Surfel& surfel : surfels) {
    const Vec3d out = surfel.position - centre;
    EXPECT_NEAR(length(out), 15, 0.2);  // where the gradient leads out of the cell; else 0.01
    EXPECT_GT(dot(surfel.normal, out) / length(out), 0.999);
    EXPECT_NEAR(surfel.deviation, 0.5 * std::sqrt(surfel.area), 1e-12);
    area += surfel.area;
  }
  EXPECT_NEAR(area, 4 * std::numbers::pi * 225, 0.02 * area);
}

}  // namespace
}  // namespace isosplat
