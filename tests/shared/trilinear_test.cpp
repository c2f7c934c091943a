#include "shared/core/sampling/trilinear.h"

#include <gtest/gtest.h>

#include "shared/core/sampling/sample.h"
#include "tests/shared/sampling_fixtures.h"

namespace isosplat {
namespace {

TEST(Trilinear, TakesTheCornersValuesExactly) {
  RandomCells random(1);
  for (int n = 0; n < 1000; ++n) {
    const CellCorners corners = random.cell();
    const Trilinear f(corners);
    for (int i = 0; i < 8; ++i) {
      const Vec3f p{float(i & 1), float(i >> 1 & 1), float(i >> 2 & 1)};
      EXPECT_EQ(f.at(p).value, corners[i]);
    }
  }
}

TEST(Trilinear, AgreesWithItsDefinition) {
  RandomCells random(2);
  for (int n = 0; n < 1000; ++n) {
    const auto corners = Trilinear::as_floats(random.cell());
    const Trilinear f(corners);
    const Vec3f p{random.unit(), random.unit(), random.unit()};
    EXPECT_NEAR(f.at(p).value, interpolate(corners, p.x, p.y, p.z), 0.1);
  }
}

// The interpolant is linear along each axis: central differences over the whole cell are exact.
TEST(Trilinear, GradientIsTheDifferenceAcrossTheCell) {
  RandomCells random(3);
  for (int n = 0; n < 1000; ++n) {
    const auto corners = Trilinear::as_floats(random.cell());
    const Vec3f p{random.unit(), random.unit(), random.unit()};
    const Vec3f gradient = Trilinear(corners).at(p).gradient;
    const double x = p.x, y = p.y, z = p.z;
    EXPECT_NEAR(gradient.x, interpolate(corners, 1, y, z) - interpolate(corners, 0, y, z), 0.1);
    EXPECT_NEAR(gradient.y, interpolate(corners, x, 1, z) - interpolate(corners, x, 0, z), 0.1);
    EXPECT_NEAR(gradient.z, interpolate(corners, x, y, 1) - interpolate(corners, x, y, 0), 0.1);
  }
}

TEST(Trilinear, IsExactForPlanes) {
  // f = 100 + 3x + 5y − 7z
  CellCorners corners;
  for (int i = 0; i < 8; ++i) {
    corners[i] =
        static_cast<QuantizedValue>(100 + 3 * (i & 1) + 5 * (i >> 1 & 1) - 7 * (i >> 2 & 1));
  }
  const Trilinear f(corners);
  const auto [value, gradient] = f.at({0.25f, 0.5f, 0.75f});
  EXPECT_EQ(value, 98.0f);
  EXPECT_EQ(gradient, (Vec3f{3, 5, -7}));
}

TEST(Sample, LiesAtTheCentreWithTheMeanOfTheCorners) {
  RandomCells random(4);
  for (int n = 0; n < 1000; ++n) {
    const CellCorners corners = random.cell();
    const Sample sample = centre_sample(corners, corner_interval(corners));
    uint32_t sum = 0;
    for (const QuantizedValue c : corners) sum += c;
    EXPECT_EQ(sample.position, (Vec3f{0.5f, 0.5f, 0.5f}));
    EXPECT_EQ(sample.value, static_cast<float>(sum) / 8);
    EXPECT_EQ(sample.interval, corner_interval(corners));
  }
}

TEST(Sample, HasTheSameBitsInEveryBuild) {
  RandomCells random(5);
  Digest digest;
  for (int n = 0; n < 10000; ++n) {
    const Trilinear f(random.cell());
    const auto [value, gradient] = f.at({random.unit(), random.unit(), random.unit()});
    digest.add(value);
    digest.add(gradient);
  }
  EXPECT_EQ(digest.value(), 9782997114533155650u);
}

}  // namespace
}  // namespace isosplat
