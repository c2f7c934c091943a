// Planes that look at each other over a gap, against a comparison of all pairs.

#include "shared/core/unstructured/opposite_planes.h"

#include <gtest/gtest.h>

#include <random>

namespace isosplat {
namespace {

bool brute_force(const std::vector<FacePlane>& planes) {
  for (size_t i = 0; i < planes.size(); ++i) {
    for (size_t k = 0; k < i; ++k) {
      if (dot(planes[i].normal, planes[k].normal) < kOpposite &&
          planes[i].distance + planes[k].distance >= 0) {
        return true;
      }
    }
  }
  return false;
}

TEST(OppositePlanes, AreThoseOfAComparisonOfAllPairs) {
  std::mt19937 random(1);
  std::normal_distribution<double> axis;
  std::uniform_real_distribution<double> one(0, 1);
  int gaps = 0, rounds = 0;
  for (const size_t count : {0, 1, 2, 20, 40, 200, 1000}) {
    for (int round = 0; round < 200; ++round, ++rounds) {
      // Around a direction in half of the rounds, and few directions in a third of them.
      const double narrow = round % 2 ? 1 : 0.8;
      std::vector<FacePlane> planes;
      for (size_t i = 0; i < count; ++i) {
        Vec3d normal{axis(random), axis(random), axis(random)};
        if (round % 3 == 0) normal = {std::round(normal.x), std::round(normal.y), 1};
        normal = normal * (1 / length(normal));
        if (round % 2) normal = normal + Vec3d{narrow, 0, 0};
        normal = normal * (1 / std::max(length(normal), 1e-9));
        // Mostly sheets, so that few pairs are gaps.
        planes.push_back({normal, one(random) - 1 + 0.02 * round / static_cast<double>(count)});
      }
      const bool expected = brute_force(planes);
      EXPECT_EQ(are_some_opposite(planes), expected) << count << ' ' << round;
      gaps += expected ? 1 : 0;
    }
  }
  EXPECT_GT(gaps, 20);
  EXPECT_LT(gaps, rounds - 200);
}

TEST(OppositePlanes, ManyPlanesOfWallsAreCompared) {
  // All pairs would be 4 · 10^10.
  std::vector<FacePlane> planes;
  for (int i = 0; i < 200'000; ++i) {
    planes.push_back({{i % 2 ? 1.0 : -1.0, 0, 0}, -1 + i * 1e-6});
    planes.push_back({{0, i % 3 ? 1.0 : -1.0, 0}, -1 - i * 1e-6});
  }
  EXPECT_FALSE(are_some_opposite(planes));
  planes.push_back({{1, 0, 0}, 0.9});
  EXPECT_TRUE(are_some_opposite(planes));
}

}  // namespace
}  // namespace isosplat
