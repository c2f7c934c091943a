#include "shared/sampling/packed_sample.h"
#include "shared/sampling/trilinear.h"

#include <gtest/gtest.h>

namespace isosplat {
namespace {

TEST(PackedSample, IsExactForSpansBelow512Codes) {
  const CellCorners corners{1000, 1511, 1300, 1001, 1255, 1256, 1400, 1499};
  const auto sample = unpack_sample(pack_sample({63, 0, 41}, corner_interval(corners), corners));
  EXPECT_EQ(sample.cell, (Index3{63, 0, 41}));
  EXPECT_EQ(sample.octant, -1);
  EXPECT_EQ(sample.interval, (CellInterval{1000, 1511}));
  EXPECT_EQ(sample.corners, Trilinear::as_floats(corners));
}

}  // namespace
}  // namespace isosplat
