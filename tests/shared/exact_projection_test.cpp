#include "shared/core/sampling/exact_projection.h"

#include <gtest/gtest.h>

#include "shared/core/sampling/sample.h"
#include "tests/shared/sampling_fixtures.h"

namespace isosplat {
namespace {

constexpr Vec3f kCentre{0.5f, 0.5f, 0.5f};

/// f(origin + t · direction) in double precision.
double along(const std::array<float, 8>& corners, Vec3f origin, Vec3f direction, double t) {
  return interpolate(corners, origin.x + t * direction.x, origin.y + t * direction.y,
                     origin.z + t * direction.z);
}

bool inside(Vec3f origin, Vec3f direction, double t) {
  for (const auto& [o, d] : {std::pair{origin.x, direction.x}, std::pair{origin.y, direction.y},
                             std::pair{origin.z, direction.z}}) {
    const double c = o + t * d;
    if (!(c >= -1e-6 && c <= 1 + 1e-6)) return false;
  }
  return true;
}

/// The nearest sign change of f − isovalue inside the cell by brute force, as |t| in cells.
std::optional<double> scan(const std::array<float, 8>& corners, Vec3f origin, Vec3f unit,
                           double isovalue) {
  constexpr int kSteps = 500;
  std::optional<double> nearest;
  for (const int sign : {1, -1}) {
    double before = along(corners, origin, unit, 0) - isovalue;
    for (int i = 1; i <= kSteps; ++i) {
      const double t = sign * 0.9 * i / kSteps;
      if (!inside(origin, unit, t)) break;
      const double now = along(corners, origin, unit, t) - isovalue;
      if ((before < 0) != (now < 0)) {
        if (!nearest || std::abs(t) < *nearest) nearest = std::abs(t);
        break;
      }
      before = now;
    }
  }
  return nearest;
}

TEST(ExactProjection, LandsOnThePlane) {
  const CellCorners corners{100, 103, 105, 108, 93, 96, 98, 101};  // 100 + 3x + 5y − 7z
  const Trilinear f(corners);
  const auto p = project_exactly(f, kCentre, f.at(kCentre).gradient, 102.25f);
  ASSERT_TRUE(p);
  EXPECT_NEAR(100 + 3 * p->x + 5 * p->y - 7 * p->z, 102.25, 1e-5);
  EXPECT_NEAR(length(cross(*p - kCentre, Vec3f{3, 5, -7})), 0, 1e-5);
}

TEST(ExactProjection, LandsOnTheIsosurfaceToAHundredThousandthOfACell) {
  RandomCells random(21);
  int found = 0;
  for (int n = 0; n < 20000; ++n) {
    const CellCorners quantized_values = random.cell();
    const auto corners = Trilinear::as_floats(quantized_values);
    const CellInterval interval = corner_interval(quantized_values);
    const float isovalue =
        interval.min + random.unit() * static_cast<float>(interval.max - interval.min);
    const Trilinear f(quantized_values);
    const Vec3f gradient = f.at(kCentre).gradient;
    const double slope = length(gradient);
    if (slope == 0) continue;
    const Vec3f unit = gradient * static_cast<float>(1 / slope);
    const auto expected = scan(corners, kCentre, unit, isovalue);
    const auto t = nearest_root_in_cell(f, kCentre, gradient, isovalue);
    // The scan may miss a pair of roots closer than its step; the solver must not.
    if (expected) {
      ASSERT_TRUE(t) << n;
      EXPECT_LE(std::abs(*t) * slope, *expected + 1e-5) << n;
    }
    if (!t) continue;
    ++found;
    EXPECT_TRUE(inside(kCentre, gradient, *t)) << n;
    // The root is within 1e-5 of a cell, or f at the root is as close to the isovalue.
    const double before = along(corners, kCentre, gradient, *t - 1e-5 / slope) - isovalue;
    const double after = along(corners, kCentre, gradient, *t + 1e-5 / slope) - isovalue;
    const double residual = along(corners, kCentre, gradient, *t) - isovalue;
    EXPECT_TRUE((before < 0) != (after < 0) || std::abs(residual) < 1e-3) << n;
    const auto p = project_exactly(f, kCentre, gradient, isovalue);
    ASSERT_TRUE(p);
    EXPECT_NEAR(length(*p - kCentre), std::abs(*t) * slope, 1e-6);
  }
  EXPECT_GT(found, 10000);
}

TEST(ExactProjection, TakesTheNearestOfThreeRoots) {
  // Along the diagonal, f − 1000 is an odd function about the centre. It falls at the centre, and
  // rises towards both ends.
  const std::array<float, 8> corners{500, 2000, 2000, 0, 2000, 0, 0, 1500};
  const Trilinear f(corners);
  const Vec3f diagonal{1, 1, 1};
  const auto value = [&](double s) { return interpolate(corners, s, s, s); };
  const auto centre = nearest_root_in_cell(f, kCentre, diagonal, 1000);
  ASSERT_TRUE(centre);
  EXPECT_NEAR(*centre, 0, 1e-7);
  // Near each end, another root is the nearest one.
  const auto low = nearest_root_in_cell(f, {0.1f, 0.1f, 0.1f}, diagonal, 1000);
  const auto high = nearest_root_in_cell(f, {0.9f, 0.9f, 0.9f}, diagonal, 1000);
  ASSERT_TRUE(low && high);
  EXPECT_LT(0.1 + *low, 0.4);
  EXPECT_GT(0.9 + *high, 0.6);
  EXPECT_NEAR(value(0.1 + *low), 1000, 1e-2);
  EXPECT_NEAR(value(0.9 + *high), 1000, 1e-2);
}

// A triple root: the derivative is 0 at the root, so Newton's method alone converges slowly.
TEST(ExactProjection, FindsATripleRoot) {
  // f = (2x − 1)(2y − 1)(2z − 1): along the diagonal (2s − 1)³.
  std::array<float, 8> corners;
  for (int i = 0; i < 8; ++i) corners[i] = (i ^ i >> 1 ^ i >> 2) & 1 ? 1.0f : -1.0f;
  const Trilinear f(corners);
  for (const float start : {0.1f, 0.3f, 0.5f, 0.77f}) {
    for (const float isovalue : {0.0f, 1e-6f, -1e-3f}) {
      const auto t = nearest_root_in_cell(f, {start, start, start}, {1, 1, 1}, isovalue);
      ASSERT_TRUE(t) << start << " " << isovalue;
      EXPECT_NEAR(start + *t, 0.5 + 0.5 * std::cbrt(double(isovalue)), 2e-5);
    }
  }
}

TEST(ExactProjection, FindsNoRootWhereTheRayMissesTheIsosurface) {
  const Trilinear f(CellCorners{0, 0, 0, 0, 0, 0, 0, 80});
  EXPECT_FALSE(nearest_root_in_cell(f, kCentre, {1, 0, 0}, 79));  // leaves through a face first
  EXPECT_TRUE(nearest_root_in_cell(f, kCentre, {1, 1, 1}, 79));
  EXPECT_FALSE(nearest_root_in_cell(f, kCentre, {1, 1, 1}, 81));    // no such value
  EXPECT_FALSE(nearest_root_in_cell(f, kCentre, {0, 0, 0}, 40));    // no direction
  EXPECT_FALSE(nearest_root_in_cell(f, {2, 2, 0}, {0, 0, 1}, 40));  // passes beside the cell
  EXPECT_FALSE(nearest_root_in_cell(f, kCentre, {1, 1, 1}, std::nanf("")));
  EXPECT_FALSE(nearest_root_in_cell(f, kCentre, {std::nanf(""), 1, 1}, 40));
}

TEST(ExactProjection, TakesDirectionsOfAnyLength) {
  const CellCorners corners{0, 100, 0, 100, 0, 100, 0, 100};
  const Trilinear f(corners);
  for (const float size : {1e-44f, 1e-30f, 1e-3f, 1e4f, 1e30f}) {
    const auto p = project_exactly(f, kCentre, {size, 0, 0}, 75);
    ASSERT_TRUE(p) << size;
    EXPECT_NEAR(p->x, 0.75f, 1e-6f) << size;
    EXPECT_EQ(p->y, 0.5f);
  }
}

// From the centre of an active cell, there may be no root along the gradient. Reports how often.
TEST(ExactProjection, FailsOnFewSmoothCells) {
  RandomCells random(22);
  int active = 0, met = 0;
  for (int n = 0; n < 20000; ++n) {
    // A plane with a little noise, as in a smooth volume.
    const float a = random.unit() * 400, b = random.unit() * 400, c = random.unit() * 400;
    CellCorners corners;
    for (int i = 0; i < 8; ++i) {
      corners[i] = static_cast<QuantizedValue>(1000 + float(i & 1) * a + float(i >> 1 & 1) * b +
                                               float(i >> 2 & 1) * c + float(random.integer(20)));
    }
    const CellInterval interval = corner_interval(corners);
    const float isovalue =
        interval.min + random.unit() * static_cast<float>(interval.max - interval.min);
    ++active;
    const Trilinear f(corners);
    met += project_exactly(f, kCentre, f.at(kCentre).gradient, isovalue).has_value();
  }
  // If the plane cuts off only a corner of the cell, the line along the normal through the centre
  // does not meet the plane in the cell.
  EXPECT_GT(met, active * 80 / 100);
}

TEST(ExactProjection, HasTheSameBitsInEveryBuild) {
  RandomCells random(23);
  Digest digest;
  for (int n = 0; n < 10000; ++n) {
    const Trilinear f(random.cell());
    const auto p = project_exactly(f, kCentre, f.at(kCentre).gradient,
                                   static_cast<float>(random.integer(65536)));
    digest.add(p.value_or(Vec3f{-1, -1, -1}));
  }
  EXPECT_EQ(digest.value(), 1827093427817348072u);
}

}  // namespace
}  // namespace isosplat
