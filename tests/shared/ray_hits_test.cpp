// Intersections of a ray with the surfaces of single cells. render_pick_gpu_test.cpp picks in whole
// volumes.
#include "shared/render/pick/ray_hits.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "shared/core/sampling/sample_neighbours.h"

namespace isosplat::render {
namespace {

/// Distances along the ray of the hits in these samples, ascending.
std::vector<double> hits_in(const PickRay& ray, uint32_t level,
                            std::span<const PackedSample> samples, float isovalue) {
  std::vector<PickHit> hits;
  add_hits(ray, {level, {0, 0, 0}}, samples, std::span(&isovalue, 1), hits);
  std::vector<double> distances;
  for (const PickHit& hit : hits) {
    EXPECT_EQ(hit.level, level);
    distances.push_back(hit.distance);
  }
  std::sort(distances.begin(), distances.end());
  return distances;
}

void expect_near(const std::vector<double>& found, const std::vector<double>& expected) {
  ASSERT_EQ(found.size(), expected.size());
  for (size_t i = 0; i < found.size(); ++i) EXPECT_NEAR(found[i], expected[i], 1e-4);
}

// 400 x (1 − y), which is 64 at 0.2 and 0.8 of the way through the cell: a wall between them.
TEST(SurfacePick, BothSidesOfAWallInOneCell) {
  const PackedSample wall[] = {pack_sample({0, 0, 0}, {0, 400}, {0, 400, 0, 0, 0, 400, 0, 0})};
  PickRay ray{{-1, -1, 0.5}, {1, 1, 0}, 0, 10};
  expect_near(hits_in(ray, 0, wall, 64), {1.2, 1.8});
  // A ray that begins between them, as after a clip plane, has only the second hit.
  ray.begin = 1.3;
  expect_near(hits_in(ray, 0, wall, 64), {1.8});
  ray.begin = 0;
  ray.end = 1.7;
  expect_near(hits_in(ray, 0, wall, 64), {1.2});
  ray.begin = 1.3;
  expect_near(hits_in(ray, 0, wall, 64), {});
}

TEST(SurfacePick, ReportsTheDistanceToTheOtherSideOfAWall) {
  const PackedSample wall[] = {pack_sample({0, 0, 0}, {0, 400}, {0, 400, 0, 0, 0, 400, 0, 0})};
  const PickRay ray{{-1, -1, 0.5}, {1, 1, 0}, 0, 10};
  const float isovalue = 64;
  std::vector<PickHit> hits;
  add_hits(ray, {0, {0, 0, 0}}, wall, std::span(&isovalue, 1), hits);
  VolumeGrid grid;
  grid.voxels = {65, 65, 65};
  const auto pick = nearest_pick(grid, {}, ray, hits);
  ASSERT_TRUE(pick);
  EXPECT_NEAR(pick->to_next, 0.6 * std::sqrt(2.0), 1e-4);
}

// A cubic along the diagonal with these three roots.
TEST(SurfacePick, ThreeIntersectionsInOneCell) {
  const PackedSample cell[] = {
      pack_sample({0, 0, 0}, {860, 1140}, {920, 1140, 1140, 860, 1140, 860, 860, 1080})};
  PickRay ray{{-1, -1, -1}, {1, 1, 1}, 0, 10};
  expect_near(hits_in(ray, 0, cell, 1000), {1.2, 1.5, 1.8});
  ray.begin = 1.4;
  expect_near(hits_in(ray, 0, cell, 1000), {1.5, 1.8});
  ray = {{2, 2, 2}, {-1, -1, -1}, 0, 1.4};
  expect_near(hits_in(ray, 0, cell, 1000), {1.2});
}

// A sheet of one voxel at level 1: it is drawn although no corner reaches the isovalue.
TEST(SurfacePick, FindsASheetThinnerThanCoarseCells) {
  std::vector<PackedSample> samples;
  for (int32_t i = 0; i < 100; ++i) {
    samples.push_back(
        pack_sample({5, i % 10, i / 10}, {0, 400}, {200, 200, 200, 200, 200, 200, 200, 200}));
  }
  mark_neighbours(samples);
  for (const double y : {0.3, 7.1, 12.9, 17.7}) {
    for (const double z : {0.1, 9.9, 15.3}) {
      const auto found = hits_in({{0, y, z}, {1, 0.02, -0.002}, 0, 100}, 1, samples, 300);
      ASSERT_GE(found.size(), 1u) << y << ", " << z;
      EXPECT_NEAR(found.front(), 11, 0.6);
    }
  }
  // The cells of the sheet end at y = 20. Inactive cells have no hits.
  EXPECT_TRUE(hits_in({{0, 25, 5}, {1, 0, 0}, 0, 100}, 1, samples, 300).empty());
  EXPECT_TRUE(hits_in({{0, 5, 5}, {1, 0, 0}, 0, 100}, 1, samples, 400).empty());
  // Level 0 has no thin structures.
  EXPECT_TRUE(hits_in({{0, 5, 5}, {1, 0, 0}, 0, 100}, 0, samples, 300).empty());
}

// Rays hit a line through the middle of cells if they pass near it, and only then.
TEST(SurfacePick, FindsALineThinnerThanCoarseCells) {
  std::vector<PackedSample> samples;
  for (int32_t x = 0; x < 10; ++x) {
    samples.push_back(pack_sample({x, 5, 5}, {0, 400}, {30, 30, 30, 30, 30, 30, 30, 30}));
  }
  mark_neighbours(samples);
  for (const double x : {0.2, 7.3, 17.5}) {
    const auto found = hits_in({{x, 11, -10}, {0, 0.001, 1}, 0, 100}, 1, samples, 300);
    ASSERT_EQ(found.size(), 1u) << x;
    EXPECT_NEAR(found.front(), 21, 0.6);
    EXPECT_TRUE(hits_in({{x, 11.9, -10}, {0, 0, 1}, 0, 100}, 1, samples, 300).empty()) << x;
  }
}

}  // namespace
}  // namespace isosplat::render
