#include "shared/sampling/subdivision.h"

#include <gtest/gtest.h>

#include "tests/shared/sampling_fixtures.h"

namespace isosplat {
namespace {

TEST(Subdivision, EvensOutAnisotropicSpacing) {
  const auto parts = [](Vec3d spacing, int32_t limit) {
    const Subdivision s = anisotropic_subdivision(spacing, limit);
    return Index3{s.x, s.y, s.z};
  };
  EXPECT_EQ(parts({1, 1, 1}, 8), (Index3{1, 1, 1}));
  EXPECT_EQ(parts({1, 1, 4}, 8), (Index3{1, 1, 4}));
  EXPECT_EQ(parts({0.34, 0.34, 0.5}, 8), (Index3{1, 1, 1}));
  EXPECT_EQ(parts({3, 1, 1.6}, 8), (Index3{3, 1, 2}));
  EXPECT_EQ(parts({1, 1, 100}, 8), (Index3{1, 1, 8}));
  EXPECT_EQ(parts({1e-30, 1, 1}, 4), (Index3{1, 4, 4}));
}

TEST(Subdivision, PlacesASampleAtEachPartsCentre) {
  const CellCorners corners{0, 60, 0, 60, 0, 60, 0, 60};  // f = 60 x
  std::vector<Sample> samples(1);
  subdivide_cell(corners, {3, 1, 2}, samples);
  ASSERT_EQ(samples.size(), 7u);  // appended
  for (int k = 0; k < 2; ++k) {
    for (int i = 0; i < 3; ++i) {
      const Sample& s = samples[1 + k * 3 + i];
      EXPECT_FLOAT_EQ(s.position.x, (float(i) + 0.5f) / 3);
      EXPECT_FLOAT_EQ(s.position.y, 0.5f);
      EXPECT_FLOAT_EQ(s.position.z, (float(k) + 0.5f) / 2);
      EXPECT_NEAR(s.value, 60 * s.position.x, 1e-4);
      EXPECT_NEAR(s.gradient.x, 60, 1e-4);
      EXPECT_NEAR(s.interval.min, 20 * i, 1);
      EXPECT_NEAR(s.interval.max, 20 * (i + 1), 1);
    }
  }
}

TEST(Subdivision, OfOnePartIsTheCellsSample) {
  RandomCells random(31);
  for (int n = 0; n < 1000; ++n) {
    const CellCorners corners = random.cell();
    std::vector<Sample> samples;
    subdivide_cell(corners, {1, 1, 1}, samples);
    const Sample expected = centre_sample(corners, corner_interval(corners));
    ASSERT_EQ(samples.size(), 1u);
    EXPECT_EQ(samples[0].position, expected.position);
    EXPECT_EQ(samples[0].value, expected.value);
    EXPECT_EQ(samples[0].gradient, expected.gradient);
    EXPECT_EQ(samples[0].interval, expected.interval);
  }
}

TEST(Subdivision, PartsAreActiveTogetherExactlyWhereTheCellIs) {
  RandomCells random(32);
  for (int n = 0; n < 2000; ++n) {
    const CellCorners corners = random.integer(2) ? random.cell() : random.cell(100, 1 + n % 40);
    const CellInterval whole = corner_interval(corners);
    const Subdivision parts{int32_t(1 + random.integer(5)), int32_t(1 + random.integer(5)),
                            int32_t(1 + random.integer(5))};
    std::vector<Sample> samples;
    subdivide_cell(corners, parts, samples);
    for (int i = 0; i < 50; ++i) {
      float isocode = whole.min - 2 + random.unit() * static_cast<float>(whole.max - whole.min + 4);
      if (i % 2) isocode = std::round(isocode);
      const bool some = std::any_of(samples.begin(), samples.end(), [isocode](const Sample& s) {
        return is_active(s.interval, isocode);
      });
      EXPECT_EQ(some, is_active(whole, isocode)) << isocode;
    }
    // Each part's interval holds the values in it.
    for (size_t i = 0; i < samples.size(); ++i) {
      EXPECT_GE(samples[i].value, static_cast<float>(samples[i].interval.min) - 0.01f);
      EXPECT_LE(samples[i].value, static_cast<float>(samples[i].interval.max) + 0.01f);
    }
  }
}

TEST(Subdivision, NarrowsIntervalsUntilTheyFit) {
  const CellCorners corners{0, 800, 0, 800, 0, 800, 0, 800};  // f = 800 x
  const auto parts = [&](float width, int32_t limit) {
    return interval_subdivision(corners, width, limit).x;
  };
  EXPECT_EQ(parts(800, 8), 1);
  EXPECT_EQ(parts(799, 8), 2);
  EXPECT_EQ(parts(400, 8), 2);
  EXPECT_EQ(parts(200, 8), 4);
  EXPECT_EQ(parts(1, 8), 8);  // as far as it is allowed to
  EXPECT_EQ(parts(1, 1), 1);
}

}  // namespace
}  // namespace isosplat
