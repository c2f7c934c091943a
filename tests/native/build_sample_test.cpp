#include <gtest/gtest.h>

#include <random>

#include "native/builder/array_source.h"
#include "native/builder/thread_executor.h"
#include "shared/core/builder/sample_volume.h"
#include "shared/core/builder/scan_volume.h"

namespace isosplat {
namespace {

constexpr Index3 kVoxels{193, 193, 193};

VolumeSample noisy_sample(unsigned threads = 2) {
  VolumeGrid grid;
  grid.voxels = kVoxels;
  std::mt19937 random(1);
  std::vector<uint8_t> voxels(size_t{193} * 193 * 193);
  for (uint8_t& voxel : voxels) voxel = static_cast<uint8_t>(100 + random() % 32);
  ArraySource<uint8_t> source(grid, voxels);
  ThreadExecutor executor(threads);
  const auto scan = scan_volume(source, executor, true, [](uint64_t) {});
  return *sample_volume(source, *choose_quantization(source.header(), *scan), executor);
}

TEST(VolumeSample, DoesNotDependOnThreads) {
  const VolumeSample one = noisy_sample(1), many = noisy_sample(5);
  ASSERT_EQ(one.columns.size(), many.columns.size());
  EXPECT_EQ(one.voxels, size_t{24} * 193 * 193);
  EXPECT_EQ(one.voxels, many.voxels);
  for (size_t i = 0; i < one.columns.size(); ++i) {
    EXPECT_EQ(one.columns[i].bits, many.columns[i].bits);
    EXPECT_TRUE(one.columns[i].intervals == many.columns[i].intervals);
  }
  // Five bits of noise.
  EXPECT_NEAR(one.columns[0].bits, 5, 0.6);
}

}  // namespace
}  // namespace isosplat
