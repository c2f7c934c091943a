// If memory runs out while several threads build, the build ends with an error, whichever
// allocation fails.
#include <gtest/gtest.h>

#include <atomic>
#include <new>
#include <stdexcept>
#include <vector>

#include "native/builder/array_source.h"
#include "native/builder/parallel.h"
#include "tests/native/refused_memory.h"

namespace isosplat {
namespace {

TEST(Parallel, AnExceptionOfAThreadIsThrownOnceAllHaveEnded) {
  for (unsigned failing = 0; failing < 4; ++failing) {
    std::atomic<int> ended{0};
    const auto work = [&](unsigned thread) {
      if (thread == failing) throw std::bad_alloc();
      ++ended;
    };
    EXPECT_THROW(on_threads(4, work), std::bad_alloc) << failing;
    EXPECT_EQ(ended, 3);
  }
}

TEST(Parallel, NothingIsBegunAfterAnException) {
  for (const unsigned threads : {1u, 3u}) {
    std::atomic<size_t> begun{0};
    const auto work = [&](unsigned, size_t) {
      if (++begun > 10) throw std::runtime_error("enough");
    };
    EXPECT_THROW(parallel_for(threads, 1'000'000, work), std::runtime_error);
    EXPECT_LE(begun, 10u + threads);
  }
}

/// A volume of several blocks and levels.
std::vector<uint8_t> voxels_of(Index3 n) {
  std::vector<uint8_t> voxels;
  for (int32_t z = 0; z < n.z; ++z) {
    for (int32_t y = 0; y < n.y; ++y) {
      for (int32_t x = 0; x < n.x; ++x) {
        voxels.push_back(static_cast<uint8_t>((x * x + 2 * y * y + 3 * z * z) >> 7));
      }
    }
  }
  return voxels;
}

TEST(BuildMemory, AnyAllocationThatFailsEndsTheBuildWithAnError) {
  is_test_thread = true;
  VolumeGrid grid;
  grid.voxels = {150, 90, 80};
  const std::vector<uint8_t> voxels = voxels_of(grid.voxels);
  BuildOptions options;
  options.threads = 3;
  const auto whole = build_store_bytes<uint8_t>(grid, voxels, options);
  ASSERT_TRUE(whole) << whole.error().message;
  int failures = 0;
  // Lets an allocation fail: at first the first one, then later ones, until the build succeeds.
  for (int64_t left = 0;; left += 1 + left / 12) {
    allocations_left = left;
    auto built = build_store_bytes<uint8_t>(grid, voxels, options);
    const bool is_spent = allocations_left < 0;
    allocations_left = -1;
    if (built) {
      EXPECT_EQ(*built, *whole);
      if (!is_spent) break;
      continue;
    }
    ++failures;
    ASSERT_EQ(built.error().status, Status::out_of_memory) << left << ": " << built.error().message;
  }
  EXPECT_GT(failures, 20);
}

}  // namespace
}  // namespace isosplat
