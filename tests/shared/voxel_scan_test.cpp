#include "shared/core/preprocess/voxel_scan.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace isosplat {
namespace {

template <class T>
VoxelScan scan_of(VoxelType type, const std::vector<T>& voxels) {
  VoxelScan scan(type);
  scan.add(std::as_bytes(std::span(voxels)));
  return scan;
}

/// Scans of two halves that exchange messages equal the scan of all voxels.
template <class T>
void expect_same_scan(VoxelType type, const std::vector<T>& voxels) {
  const auto half = voxels.begin() + static_cast<ptrdiff_t>(voxels.size() / 3);
  const VoxelScan all = scan_of(type, voxels);
  VoxelScan sum(type);
  for (const std::vector<T>& part :
       {std::vector<T>(voxels.begin(), half), std::vector<T>(half, voxels.end())}) {
    ASSERT_TRUE(sum.add_message(scan_of(type, part).bytes()));
  }
  EXPECT_EQ(sum.is_empty(), all.is_empty());
  EXPECT_EQ(sum.missing(), all.missing());
  EXPECT_EQ(sum.low(), all.low());
  EXPECT_EQ(sum.high(), all.high());
  EXPECT_EQ(sum.step(), all.step());
  EXPECT_EQ(sum.distinct().has_too_many(), all.distinct().has_too_many());
  EXPECT_EQ(sum.distinct().sorted(), all.distinct().sorted());
  if (all.is_empty()) return;
  EXPECT_EQ(sum.min(), all.min());
  EXPECT_EQ(sum.max(), all.max());
}

TEST(VoxelScanMessage, SumsOfMessagesAreTheScanOfAllVoxels) {
  expect_same_scan<int16_t>(VoxelType::i16, {-30, 12, 6, 900, -12, 0, 6});
  expect_same_scan<uint32_t>(VoxelType::u32, {4000000000, 8, 16, 24});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  expect_same_scan<double>(VoxelType::f64, {nan, 0.25, -0.0, 7.5, nan, -3, 0.25});
  expect_same_scan<double>(VoxelType::f64, {nan, nan, nan});
  std::vector<float> many;
  for (int i = 0; i < 300'000; ++i) many.push_back(std::sqrt(static_cast<float>(i)));
  expect_same_scan<float>(VoxelType::f32, many);
}

TEST(VoxelScanMessage, OtherMessagesAreErrors) {
  const std::vector<std::byte> message = scan_of<double>(VoxelType::f64, {0.25, 7.5, -3}).bytes();
  VoxelScan scan(VoxelType::f64), other(VoxelType::f32);
  EXPECT_FALSE(other.add_message(message));
  for (size_t length = 0; length < message.size(); ++length) {
    EXPECT_FALSE(scan.add_message(std::span(message).first(length))) << length;
  }
  std::vector<std::byte> longer = message;
  longer.emplace_back();
  EXPECT_FALSE(scan.add_message(longer));
  EXPECT_TRUE(scan.is_empty());
  EXPECT_TRUE(scan.add_message(message));
}

}  // namespace
}  // namespace isosplat
