#include "native/remote/recent_ranges.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace isosplat::remote {
namespace {

std::vector<std::byte> bytes_at(uint64_t offset, size_t count) {
  std::vector<std::byte> bytes(count);
  for (size_t i = 0; i < count; ++i) bytes[i] = static_cast<std::byte>((offset + i) * 7);
  return bytes;
}

bool has(const RecentRanges& ranges, uint64_t offset, size_t count) {
  std::vector<std::byte> out(count);
  if (!ranges.read(offset, out)) return false;
  EXPECT_EQ(out, bytes_at(offset, count));
  return true;
}

TEST(RemoteRecentRanges, HaveTheBytesWithinEachRange) {
  RecentRanges ranges(1000);
  ranges.add(100, bytes_at(100, 50));
  ranges.add(200, bytes_at(200, 50));
  EXPECT_TRUE(has(ranges, 100, 50));
  EXPECT_TRUE(has(ranges, 149, 1));
  EXPECT_TRUE(has(ranges, 210, 20));
  EXPECT_FALSE(has(ranges, 99, 2));
  EXPECT_FALSE(has(ranges, 140, 11));
  EXPECT_FALSE(has(ranges, 150, 1));
  EXPECT_FALSE(has(ranges, 0, 1));
  EXPECT_FALSE(has(ranges, UINT64_MAX, 1));
}

TEST(RemoteRecentRanges, TheOldestAreDroppedFirst) {
  RecentRanges ranges(1000);
  for (uint64_t i = 0; i < 20; ++i) ranges.add(i * 1000, bytes_at(i * 1000, 100));
  for (uint64_t i = 0; i < 20; ++i) EXPECT_EQ(has(ranges, i * 1000, 100), i >= 10) << i;
}

TEST(RemoteRecentRanges, LargeRangesAreNotKept) {
  RecentRanges ranges(1000);
  ranges.add(0, bytes_at(0, 100));
  ranges.add(1000, bytes_at(1000, 251));
  EXPECT_TRUE(has(ranges, 0, 100));
  EXPECT_FALSE(has(ranges, 1000, 1));
}

}  // namespace
}  // namespace isosplat::remote
