// Builds whose memory limit does not allow whole layers read and encode bands of rows. They give
// byte for byte the store of a build with whole layers.
#include <gtest/gtest.h>
#include <malloc.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>

#include "native/builder/kept_blocks.h"
#include "native/builder/part_build.h"
#include "shared/core/builder/memory_plan.h"
#include "tests/native/temporary_folder.h"
#include "tests/native/wave_volume.h"

namespace isosplat {
namespace {

using test::Volume;

/// A source whose volume is not in memory, as far as the memory plan knows.
class StreamedSource : public VolumeSource {
 public:
  explicit StreamedSource(VolumeSource& source) : source_(source) {}
  const VolumeHeader& header() const override { return source_.header(); }
  Result<void> read_slices(int32_t first, int32_t count, std::span<std::byte> out) override {
    return source_.read_slices(first, count, out);
  }
  bool reads_rows() const override { return true; }
  Result<void> read_rows(const SliceRows& part, std::span<std::byte> out) override {
    return source_.read_rows(part, out);
  }
  uint64_t resident_bytes() const override { return 0; }
  std::vector<std::filesystem::path> files() const override { return {}; }

 private:
  VolumeSource& source_;
};

/// The least memory in which the volume can be built; only bands of one row of blocks fit.
template <class T>
BuildOptions with_least_memory(const Volume<T>& volume, unsigned threads,
                               BuildOptions options = {}) {
  ArraySource<T> source = volume.source();
  StreamedSource streamed(source);
  options.threads = threads;
  options.memory_bytes = min_memory(streamed, options);
  const auto plan = plan_memory(source.header(), 0, true, threads, true, options.memory_bytes);
  EXPECT_TRUE(plan && plan->band_rows[0] == 1);
  return options;
}

template <class T>
std::string build(const Volume<T>& volume, const BuildOptions& options) {
  ArraySource<T> array = volume.source();
  StreamedSource source(array);
  MemorySink sink;
  const auto built = build_store(source, sink, options);
  EXPECT_TRUE(built) << built.error().message;
  if (built) {
    EXPECT_LE(built->needed_bytes, options.memory_bytes);
  }
  return Volume<T>::text(sink.bytes);
}

constexpr Index3 kSizes[] = {{66, 300, 131}, {131, 129, 67}, {2, 200, 65}, {70, 194, 195}};

template <class T>
class BandsOfType : public testing::Test {};
using VoxelTypes = testing::Types<uint8_t, int16_t, float>;
TYPED_TEST_SUITE(BandsOfType, VoxelTypes);

TYPED_TEST(BandsOfType, GiveTheStoreOfWholeLayers) {
  for (const Index3 n : kSizes) {
    for (const double noise : {0.02, 1.0}) {  // size limits change the blocks of noise
      SCOPED_TRACE(testing::Message() << n.x << " x " << n.y << " x " << n.z << ", " << noise);
      const Volume<TypeParam> volume(n, noise);
      const std::string whole = volume.store();
      for (const unsigned threads : {1u, 3u}) {
        EXPECT_TRUE(build(volume, with_least_memory(volume, threads)) == whole) << threads;
      }
    }
  }
}

TEST(BuildBands, GiveTheStoreOfWholeLayersWithARange) {
  const Volume<float> volume({66, 300, 131}, 0.1);
  ClampedVoxels in_layers, in_bands;
  BuildOptions options;
  options.range = ValueRange{40, 150};
  options.clamped = &in_layers;
  const std::string whole = volume.store(options);
  options.clamped = &in_bands;
  EXPECT_TRUE(build(volume, with_least_memory(volume, 2, options)) == whole);
  EXPECT_GT(in_bands.below, 0u);
  EXPECT_EQ(in_bands.below, in_layers.below);
  EXPECT_EQ(in_bands.above, in_layers.above);
}

TEST(BuildBands, PartsMayHaveBandsOfDifferentSizes) {
  const Volume<uint8_t> volume({131, 300, 131}, 0.02);
  const TemporaryFolder folder;
  for (const uint32_t count : {2u, 3u, 7u, 40u}) {
    std::vector<std::filesystem::path> paths;
    for (uint32_t number = 1; number <= count; ++number) {
      ArraySource<uint8_t> source = volume.source();
      BuildOptions options;
      if (number % 2) options = with_least_memory(volume, 1 + number % 3);
      if (number % 2) options.memory_bytes += source.resident_bytes();
      paths.push_back(folder.path() / (std::to_string(number) + "of" + std::to_string(count)));
      const auto built = build_part_file(source, paths.back(), options, {number, count});
      ASSERT_TRUE(built) << built.error().message;
    }
    auto kept = KeptBlocks::of_parts(paths);
    ASSERT_TRUE(kept) << kept.error().message;
    BuildOptions options = with_least_memory(volume, 2);
    options.kept = kept->get();
    EXPECT_TRUE(build(volume, options) == volume.store()) << count;
  }
}

TEST(BuildBands, AResumedBuildMayHaveOtherBands) {
  const Volume<uint8_t> volume({131, 300, 131}, 0.02);
  const TemporaryFolder folder;
  for (const bool is_first : {true, false}) {
    auto kept = KeptBlocks::of_interrupted(folder.path() / "kept");
    ASSERT_TRUE(kept) << kept.error().message;
    BuildOptions options = with_least_memory(volume, 2);
    if (!is_first) options.memory_bytes = uint64_t{1} << 30;
    options.kept = kept->get();
    EXPECT_TRUE(build(volume, options) == volume.store());
    uint64_t blocks = 0;
    for (uint32_t l = 0; l < level_count(volume.grid.voxels); ++l) {
      blocks += level_grid(volume.grid.voxels, l).block_count();
    }
    EXPECT_EQ((*kept)->taken(), is_first ? 0 : blocks);
  }
}

TEST(BuildBands, ThePlanHasWholeLayersIfTheyFit) {
  VolumeHeader header;
  header.grid.voxels = {8192, 8192, 512};
  header.type = VoxelType::u16;
  const auto plan = [&](bool reads_rows, uint64_t limit) {
    return plan_memory(header, 0, reads_rows, 2, true, limit);
  };
  const auto wide = plan(true, uint64_t{64} << 30);
  ASSERT_TRUE(wide);
  EXPECT_EQ(wide->band_rows[0], 128);
  const auto narrow = plan(true, uint64_t{1} << 30);
  ASSERT_TRUE(narrow);
  EXPECT_LT(narrow->band_rows[0], 128);
  EXPECT_LE(narrow->bytes, uint64_t{1} << 30);
  EXPECT_GT(narrow->bytes, uint64_t{1} << 28);
  const auto slices = plan(false, uint64_t{1} << 30);
  ASSERT_FALSE(slices);
  EXPECT_EQ(slices.error().status, Status::out_of_memory);
  EXPECT_NE(slices.error().message.find("whole slices"), std::string::npos);
}

/// Wide slices, which are computed: a ramp with large constant parts.
class WideSource : public VolumeSource {
 public:
  explicit WideSource(Index3 n) {
    header_.grid.voxels = n;
    header_.type = VoxelType::u8;
  }
  const VolumeHeader& header() const override { return header_; }
  Result<void> read_slices(int32_t first, int32_t count, std::span<std::byte> out) override {
    return read_rows({first, count, 0, header_.grid.voxels.y}, out);
  }
  bool reads_rows() const override { return true; }
  Result<void> read_rows(const SliceRows& part, std::span<std::byte> out) override {
    const auto row = static_cast<size_t>(header_.grid.voxels.x);
    std::byte* to = out.data();
    for (int32_t z = part.first_slice; z < part.first_slice + part.slices; ++z) {
      for (int32_t y = part.first_row; y < part.first_row + part.rows; ++y, to += row) {
        std::fill_n(to, row, static_cast<std::byte>(std::min(255, (y / 4 + z) / 8)));
      }
    }
    return {};
  }
  uint64_t resident_bytes() const override { return 0; }
  std::vector<std::filesystem::path> files() const override { return {}; }

 private:
  VolumeHeader header_;
};

TEST(BuildBands, StayWithinTheirMemory) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers need memory of their own";
#endif
  const TemporaryFolder folder;
  constexpr uint64_t kLimit = 160 << 20;
  WideSource source({1000, 2000, 66});
  BuildOptions options;
  options.threads = 2;
  options.memory_bytes = kLimit;
  const auto of_layers = plan_memory(source.header(), 0, false, options.threads, true, UINT64_MAX);
  EXPECT_GT(of_layers->min_bytes, kLimit + kLimit / 2);
  ::malloc_trim(0);  // the child has this process's memory
  const pid_t child = ::fork();
  if (child == 0) {
    const auto report = build_store_file(source, folder.path() / "wide.isosplat", options);
    ::_exit(report && report->uses_temporary_files ? 0 : 1);
  }
  int status = 0;
  rusage usage{};
  ::wait4(child, &status, 0, &usage);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
  EXPECT_LE(static_cast<uint64_t>(usage.ru_maxrss) * 1024, kLimit);
}

}  // namespace
}  // namespace isosplat
