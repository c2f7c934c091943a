// If memory runs out while several threads decode and project, the result is an error, whichever
// allocation fails.
#include <gtest/gtest.h>

#include <thread>

#include "native/builder/array_source.h"
#include "native/extract/extract.h"
#include "tests/native/refused_memory.h"
#include "tests/native/temporary_folder.h"

namespace isosplat {
namespace {

class ExtractMemory : public testing::Test {
 protected:
  void SetUp() override {
    VolumeGrid grid;
    grid.voxels = {130, 70, 20};
    std::vector<uint8_t> voxels;
    for (int32_t z = 0; z < grid.voxels.z; ++z) {
      for (int32_t y = 0; y < grid.voxels.y; ++y) {
        for (int32_t x = 0; x < grid.voxels.x; ++x) {
          voxels.push_back(static_cast<uint8_t>((x * x + 2 * y * y + 3 * z * z) >> 7));
        }
      }
    }
    const auto path = folder_.path() / "several_blocks.isosplat";
    ASSERT_TRUE(build_store_file<uint8_t>(grid, voxels, path));
    auto opened = StoreFile::open(path);
    ASSERT_TRUE(opened) << opened.error().message;
    store_ = std::move(*opened);
    is_test_thread = true;
  }
  void TearDown() override {
    allocations_left = -1;
    is_test_thread = false;
  }

  /// Calls work() repeatedly, on a new thread. In each call, another allocation of this thread, or
  /// of the threads that it starts, fails, until each has failed once. Returns how often work()
  /// returned an error.
  template <class Work>
  int refuse_in_turn(const Work& work) {
    int failures = 0;
    for (int64_t left = 0;; ++left) {
      Status status = Status::ok;
      allocations_left = left;
      std::thread([&] { status = work(); }).join();
      const bool is_spent = allocations_left < 0;
      allocations_left = -1;
      if (status != Status::ok) {
        ++failures;
        EXPECT_EQ(status, Status::out_of_memory) << left;
      } else if (!is_spent) {
        return failures;
      }
    }
  }

  TemporaryFolder folder_;
  std::shared_ptr<StoreFile> store_;
  const ExtractOptions options_{.level = 0, .threads = 3};
};

TEST_F(ExtractMemory, AnyAllocationThatFailsEndsPointsWithAnError) {
  const auto extract = [&] {
    const auto take = [](const PointArrays&) { return Result<void>{}; };
    const auto count = extract_points(*store_, 60.5, {}, options_, take);
    return count ? Status::ok : count.error().status;
  };
  ASSERT_EQ(extract(), Status::ok);
  EXPECT_GT(refuse_in_turn(extract), 5);
}

TEST_F(ExtractMemory, AnyAllocationThatFailsEndsSamplesWithAnErrorAndNoSamples) {
  std::vector<ChunkSamples> samples;
  const auto extract = [&] {
    samples.clear();
    const auto done = extract_samples(*store_, 60.5, options_, samples);
    if (done) return Status::ok;
    EXPECT_TRUE(samples.empty());
    return done.error().status;
  };
  ASSERT_EQ(extract(), Status::ok);
  EXPECT_GT(refuse_in_turn(extract), 5);
}

}  // namespace
}  // namespace isosplat
