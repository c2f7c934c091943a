#include "shared/core/sampling/sample_neighbours.h"

#include <gtest/gtest.h>

#include <vector>

namespace isosplat {
namespace {

/// A cell of a background of 10 with a structure that reaches this value between its corners.
PackedSample cell_with_peak(Index3 cell, QuantizedValue peak) {
  return pack_sample(cell, {10, peak}, {10, 20, 10, 20, 10, 20, 10, 20});
}

TEST(SampleNeighbours, ContinueWhereTheStructureDoes) {
  std::vector<PackedSample> samples = {
      cell_with_peak({5, 5, 5}, 200), cell_with_peak({6, 5, 5}, 180),
      cell_with_peak({4, 5, 5}, 60),  // touched by it only
      cell_with_peak({5, 4, 5}, 200), cell_with_peak({5, 5, 6}, 230)};
  mark_neighbours(samples);
  EXPECT_EQ(neighbours_of(samples[0]), 1u << 1 | 1u << 2 | 1u << 5);
  EXPECT_EQ(neighbours_of(samples[1]), 1u << 0);
  EXPECT_EQ(neighbours_of(samples[2]), 1u << 1);
  EXPECT_EQ(neighbours_of(samples[3]), 1u << 3);
  EXPECT_EQ(neighbours_of(samples[4]), 1u << 4);
}

TEST(SampleNeighbours, DarkStructuresContinueIntoDarkOnes) {
  const CellCorners corners{200, 190, 200, 190, 200, 190, 200, 190};
  std::vector<PackedSample> samples = {pack_sample({5, 5, 5}, {10, 210}, corners),
                                       pack_sample({6, 5, 5}, {30, 205}, corners),
                                       pack_sample({4, 5, 5}, {150, 250}, corners)};
  mark_neighbours(samples);
  EXPECT_EQ(neighbours_of(samples[0]), 1u << 1);
}

TEST(SampleNeighbours, ContinueBeyondTheBlockAsAcrossTheOppositeFace) {
  std::vector<PackedSample> samples = {cell_with_peak({0, 63, 7}, 200),
                                       cell_with_peak({1, 63, 7}, 200)};
  mark_neighbours(samples);
  EXPECT_EQ(neighbours_of(samples[0]), 3u);  // x on both sides; nothing below y = 63
  EXPECT_EQ(neighbours_of(samples[1]), 1u);
}

TEST(SampleNeighbours, LeaveTheContentAsItIs) {
  std::vector<PackedSample> samples = {
      pack_sample({63, 0, 21}, {0, 511}, {0, 511, 300, 1, 255, 256, 400, 499}),
      pack_sample({62, 0, 21}, {0, 500}, {0, 500, 300, 1, 255, 256, 400, 499})};
  const std::vector<PackedSample> before = samples;
  mark_neighbours(samples);
  EXPECT_NE(samples[0].word[0], before[0].word[0]);
  for (size_t i = 0; i < samples.size(); ++i) {
    const UnpackedSample a = unpack_sample(before[i]), b = unpack_sample(samples[i]);
    EXPECT_EQ(a.cell, b.cell);
    EXPECT_EQ(a.interval, b.interval);
    EXPECT_EQ(a.corners, b.corners);
  }
  std::vector<PackedSample> again = samples;
  mark_neighbours(again);
  EXPECT_EQ(again, samples);
}

}  // namespace
}  // namespace isosplat
