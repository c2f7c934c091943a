#include "shared/core/sampling/cell.h"

#include <gtest/gtest.h>

#include "tests/shared/sampling_fixtures.h"

namespace isosplat {
namespace {

TEST(Cell, IntervalIsTheRangeOfItsCorners) {
  EXPECT_EQ(corner_interval({5, 9, 3, 7, 5, 5, 8, 4}), (CellInterval{3, 9}));
  EXPECT_EQ(corner_interval({0, 0, 0, 0, 0, 0, 0, 65535}), (CellInterval{0, 65535}));
  EXPECT_EQ(corner_interval({12, 12, 12, 12, 12, 12, 12, 12}), (CellInterval{12, 12}));
}

TEST(Cell, IsActiveFromItsMinimumToBelowItsMaximum) {
  constexpr CellInterval kInterval{10, 20};
  EXPECT_FALSE(is_active(kInterval, std::nextafter(10.0f, 0.0f)));
  EXPECT_TRUE(is_active(kInterval, 10.0f));
  EXPECT_TRUE(is_active(kInterval, 15.5f));
  EXPECT_TRUE(is_active(kInterval, std::nextafter(20.0f, 0.0f)));
  EXPECT_FALSE(is_active(kInterval, 20.0f));
}

TEST(Cell, IsNeverActiveWhenConstantEmptyOrForNaN) {
  EXPECT_FALSE(is_active({7, 7}, 7.0f));
  EXPECT_FALSE(is_active({9, 7}, 8.0f));
  EXPECT_FALSE(is_active({0, 65535}, std::nanf("")));
}

TEST(Cell, IsActiveAtEndsOfTheRange) {
  EXPECT_TRUE(is_active({0, 65535}, 0.0f));
  EXPECT_TRUE(is_active({0, 65535}, 65534.996f));
  EXPECT_FALSE(is_active({0, 65535}, 65535.0f));
  EXPECT_FALSE(is_active({0, 65535}, -0.001f));
}

// Half-open intervals: along a line of voxels that rises through the isovalue exactly one cell is
// active, even if the isovalue is a voxel's value.
TEST(Cell, VoxelsThatEqualTheIsovalueBelongToOneSide) {
  for (float quantized_isovalue = 0; quantized_isovalue < 8; quantized_isovalue += 0.5f) {
    int active = 0;
    for (QuantizedValue v = 0; v < 8; ++v)
      active += is_active({v, static_cast<QuantizedValue>(v + 1)}, quantized_isovalue);
    EXPECT_EQ(active, 1) << quantized_isovalue;
  }
}

}  // namespace
}  // namespace isosplat
