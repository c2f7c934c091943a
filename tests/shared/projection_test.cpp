#include "shared/core/sampling/projection.h"

#include <gtest/gtest.h>

#include "shared/core/sampling/sample.h"
#include "tests/shared/sampling_fixtures.h"

namespace isosplat {
namespace {

TEST(Projection, LandsOnAPlaneInOneStep) {
  RandomCells random(11);
  for (int n = 0; n < 1000; ++n) {
    // f = 30000 + a x + b y + c z, with coefficients between −1000 and 1000, not all zero.
    const Vec3f slope{float(random.integer(2001)) - 1000, float(random.integer(2001)) - 1000, 500};
    CellCorners corners;
    for (int i = 0; i < 8; ++i) {
      corners[i] =
          static_cast<QuantizedValue>(30000 + float(i & 1) * slope.x + float(i >> 1 & 1) * slope.y +
                                      float(i >> 2 & 1) * slope.z);
    }
    const Sample sample = centre_sample(corners, corner_interval(corners));
    const float isovalue =
        sample.interval.min +
        random.unit() * static_cast<float>(sample.interval.max - sample.interval.min);
    const auto p = project(sample.position, sample.value, sample.gradient, isovalue);
    ASSERT_TRUE(p);
    EXPECT_NEAR(30000 + double(p->x) * slope.x + double(p->y) * slope.y + double(p->z) * slope.z,
                isovalue, 1e-5 * length(slope));
    // The step is along the normal.
    EXPECT_NEAR(length(cross(*p - sample.position, slope)), 0, 1e-5f * length(slope));
  }
}

// One Newton step leaves an error that is quadratic in the distance to the surface: for
// f = |p|² it is (|p| − r)² / (2 |p|), by Newton's iteration for the square root.
TEST(Projection, ErrorOnASphereIsQuadraticInTheDistance) {
  const Vec3d direction{2.0 / 7, 3.0 / 7, 6.0 / 7};
  constexpr double kRadius = 10;
  double previous = 0;
  for (double distance = 2; distance > 0.05; distance /= 2) {
    const Vec3d p = direction * (kRadius + distance);
    const Vec3f position{float(p.x), float(p.y), float(p.z)};
    const auto q = project(position, float(dot(p, p)), position * 2.0f, float(kRadius * kRadius));
    ASSERT_TRUE(q);
    const double error = length(Vec3d{q->x, q->y, q->z}) - kRadius;
    EXPECT_NEAR(error, distance * distance / (2 * (kRadius + distance)), 1e-5);
    if (previous > 0) {
      EXPECT_NEAR(previous / error, 4, 0.5);
    }
    previous = error;
  }
}

// The same, computed from voxels. On a finer grid, the part of a sphere in a cell is closer to a
// plane. The largest distance of projected samples from the sphere decreases with the square of the
// cell's size.
TEST(Projection, SamplesOfASphereConvergeQuadratically) {
  double previous = 0;
  for (const int n : {16, 32, 64}) {
    const double h = 2.0 / n;
    constexpr double kRadius = 0.7;
    const auto field = [&](int x, int y, int z) {
      const Vec3d p{x * h - 1, y * h - 1, z * h - 1};
      return static_cast<float>(length(p));
    };
    double worst = 0;
    for (int z = 0; z < n; ++z) {
      for (int y = 0; y < n; ++y) {
        for (int x = 0; x < n; ++x) {
          std::array<float, 8> corners;
          for (int i = 0; i < 8; ++i) {
            corners[i] = field(x + (i & 1), y + (i >> 1 & 1), z + (i >> 2 & 1));
          }
          const auto [min, max] = std::minmax_element(corners.begin(), corners.end());
          if (!(*min <= kRadius && kRadius < *max)) continue;
          const auto [value, gradient] = Trilinear(corners).at({0.5f, 0.5f, 0.5f});
          const auto p = project({0.5f, 0.5f, 0.5f}, value, gradient, float(kRadius));
          ASSERT_TRUE(p);
          const Vec3d q{(x + double(p->x)) * h - 1, (y + double(p->y)) * h - 1,
                        (z + double(p->z)) * h - 1};
          worst = std::max(worst, std::abs(length(q) - kRadius));
        }
      }
    }
    if (previous > 0) {
      EXPECT_NEAR(previous / worst, 4, 1);
    }
    previous = worst;
  }
}

TEST(Projection, HasNoDirectionWhereTheGradientVanishes) {
  EXPECT_FALSE(project({0.5f, 0.5f, 0.5f}, 10, {0, 0, 0}, 12));
  EXPECT_FALSE(project({0.5f, 0.5f, 0.5f}, 10, {std::nanf(""), 0, 0}, 12));
  // A saddle has a gradient of 0 at its centre: a checkerboard of corners 0 and 1.
  const Sample saddle = centre_sample({0, 9, 9, 0, 9, 0, 0, 9}, {0, 9});
  EXPECT_EQ(saddle.gradient, (Vec3f{0, 0, 0}));
  EXPECT_FALSE(project(saddle.position, saddle.value, saddle.gradient, 3));
}

TEST(Projection, ThresholdIsHalfTheCellsDiagonal) {
  EXPECT_DOUBLE_EQ(displacement_threshold(kIdentity3), std::sqrt(3) / 2);
  EXPECT_DOUBLE_EQ(displacement_threshold(scale_columns(kIdentity3, {2, 3, 6})), 3.5);
  // In a sheared cell, the diagonals have different lengths: no corner is farther from the centre
  // than half the longest one.
  EXPECT_DOUBLE_EQ(displacement_threshold({1, 1, 0, 0, 1, 0, 0, 0, 2}), 1.5);
  EXPECT_DOUBLE_EQ(displacement_threshold({1, -1, 0, 0, 1, 0, 0, 0, 2}), 1.5);
}

// Figure 3 of the paper: the threshold drops samples that a flat gradient throws far away, and
// keeps every sample whose isosurface is a plane through its cell.
TEST(Projection, ThresholdKeepsPlanesAndDropsFarJumps) {
  RandomCells random(12);
  for (int n = 0; n < 1000; ++n) {
    const Vec3f slope{float(random.integer(2001)) - 1000, float(random.integer(2001)) - 1000, 500};
    const Vec3f inside{random.unit(), random.unit(), random.unit()};
    const Vec3f centre{0.5f, 0.5f, 0.5f};
    const auto p = project(centre, dot(slope, centre), slope, dot(slope, inside));
    ASSERT_TRUE(p);
    EXPECT_LE(length(*p - centre), displacement_threshold(kIdentity3) * 1.0001);
  }
  const Sample flat = centre_sample({0, 0, 0, 0, 0, 0, 0, 80}, {0, 80});
  const auto p = project(flat.position, flat.value, flat.gradient, 79);
  ASSERT_TRUE(p);
  EXPECT_GT(length(*p - flat.position), displacement_threshold(kIdentity3));
}

}  // namespace
}  // namespace isosplat
