#include "shared/core/sampling/packed_sample.h"

#include <gtest/gtest.h>

#include "tests/shared/sampling_fixtures.h"

namespace isosplat {
namespace {

TEST(PackedSample, IsExactForSpansBelow512Codes) {
  const CellCorners corners{1000, 1511, 1300, 1001, 1255, 1256, 1400, 1499};
  const auto sample = unpack_sample(pack_sample({63, 0, 41}, corner_interval(corners), corners));
  EXPECT_EQ(sample.cell, (Index3{63, 0, 41}));
  EXPECT_EQ(sample.interval, (CellInterval{1000, 1511}));
  EXPECT_EQ(sample.corners, Trilinear::as_floats(corners));
}

TEST(PackedSample, KeepsPositionAndInterval) {
  RandomCells random(41);
  for (int n = 0; n < 10000; ++n) {
    const CellCorners corners = random.cell();
    const Index3 cell{int32_t(random.integer(64)), int32_t(random.integer(64)),
                      int32_t(random.integer(64))};
    const CellInterval interval = corner_interval(corners);
    const PackedSample packed = pack_sample(cell, interval, corners);
    const UnpackedSample sample = unpack_sample(packed);
    EXPECT_EQ(sample.cell, cell);
    EXPECT_EQ(sample.interval, interval);
    EXPECT_EQ(packed.word[0] >> 30, 0u);
  }
}

TEST(PackedSample, KeepsCornersOfEverySpan) {
  RandomCells random(42);
  for (uint32_t span = 0; span < 65536; span += span < 1100 ? 1 : 1 + random.integer(40)) {
    const uint32_t low = random.integer(65536 - span);
    const CellCorners corners = random.cell(low, span);
    const UnpackedSample sample =
        unpack_sample(pack_sample({1, 2, 3}, corner_interval(corners), corners));
    for (int i = 0; i < 8; ++i) {
      const float error = std::abs(sample.corners[i] - static_cast<float>(corners[i]));
      EXPECT_LE(error, span < 512 ? 0.0f : static_cast<float>(span) / 512) << span;
    }
  }
}

// At coarse levels, the interval is that of the finer cells. The corners may exceed it, or not
// reach its ends.
TEST(PackedSample, ClampsCornersIntoAForeignInterval) {
  const CellCorners corners{5, 10, 15, 20, 25, 30, 35, 40};
  const UnpackedSample narrow = unpack_sample(pack_sample({0, 0, 0}, {12, 33}, corners));
  EXPECT_EQ(narrow.corners, (std::array<float, 8>{12, 12, 15, 20, 25, 30, 33, 33}));
  EXPECT_EQ(narrow.interval, (CellInterval{12, 33}));
  const UnpackedSample wide = unpack_sample(pack_sample({0, 0, 0}, {0, 500}, corners));
  EXPECT_EQ(wide.corners, Trilinear::as_floats(corners));
}

TEST(PackedSample, ShiftsOnlyAsFarAsItMust) {
  EXPECT_EQ(corner_shift({0, 0}), 0);
  EXPECT_EQ(corner_shift({100, 611}), 0);
  EXPECT_EQ(corner_shift({100, 612}), 1);
  EXPECT_EQ(corner_shift({0, 1023}), 1);
  EXPECT_EQ(corner_shift({0, 1024}), 2);
  EXPECT_EQ(corner_shift({0, 65535}), 7);
  EXPECT_EQ(corner_shift({9, 3}), 0);
}

TEST(PackedSample, HasTheSameBitsInEveryBuild) {
  RandomCells random(43);
  Digest digest;
  for (int n = 0; n < 10000; ++n) {
    const CellCorners corners = random.cell();
    const Index3 cell{int32_t(random.integer(64)), int32_t(random.integer(64)),
                      int32_t(random.integer(64))};
    const PackedSample packed = pack_sample(cell, corner_interval(corners), corners);
    digest.add(packed);
    for (const float c : unpack_sample(packed).corners) digest.add(c);
  }
  EXPECT_EQ(digest.value(), 10310461613206214291u);
}

}  // namespace
}  // namespace isosplat
