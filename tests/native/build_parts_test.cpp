// Builds in parts, and builds that are resumed, give byte for byte the store of one build.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <random>

#include "native/builder/kept_blocks.h"
#include "native/builder/part_build.h"
#include "tests/native/temporary_folder.h"
#include "tests/native/test_files.h"
#include "tests/native/wave_volume.h"

namespace isosplat {
namespace {

using test::read_file;
using test::Volume;
using test::waves;
using test::write_file;

std::filesystem::path part_path(const TemporaryFolder& folder, uint32_t number, uint32_t count) {
  return folder.path() / ("part" + std::to_string(number) + "of" + std::to_string(count));
}

template <class T>
std::vector<std::filesystem::path> build_parts(const Volume<T>& volume, const TemporaryFolder& to,
                                               uint32_t count, const BuildOptions& options = {}) {
  std::vector<std::filesystem::path> paths;
  for (uint32_t number = count; number >= 1; --number) {
    ArraySource<T> source = volume.source();
    paths.push_back(part_path(to, number, count));
    const auto built = build_part_file(source, paths.back(), options, {number, count});
    EXPECT_TRUE(built) << built.error().message;
  }
  return paths;
}

struct Joined {
  std::string store;
  uint64_t taken = 0, changed = 0;
  std::string error;
};

/// Builds the store with kept blocks.
template <class T>
Joined build_with(const Volume<T>& volume, Result<std::unique_ptr<KeptBlocks>> kept,
                  BuildOptions options) {
  if (!kept) return {"", 0, 0, kept.error().message};
  ArraySource<T> source = volume.source();
  MemorySink sink;
  options.kept = kept->get();
  const auto built = build_store(source, sink, options);
  if (!built) return {"", 0, 0, built.error().message};
  return {Volume<T>::text(sink.bytes), (*kept)->taken(), (*kept)->changed(), ""};
}

template <class T>
Joined join(const Volume<T>& volume, const std::vector<std::filesystem::path>& parts,
            const BuildOptions& options = {}) {
  return build_with(volume, KeptBlocks::of_parts(parts), options);
}

constexpr Index3 kSizes[] = {{2, 3, 2}, {65, 64, 63}, {131, 67, 200}, {3, 129, 66}, {70, 70, 195}};

template <class T>
class PartsOfType : public testing::Test {};
using VoxelTypes = testing::Types<uint8_t, int16_t, float>;
TYPED_TEST_SUITE(PartsOfType, VoxelTypes);

TYPED_TEST(PartsOfType, AnyNumberOfPartsGivesTheStoreOfOneBuild) {
  for (const Index3 n : kSizes) {
    for (const double noise : {0.0, 0.6}) {
      if (noise > 0 && n.z < 100) continue;
      const Volume<TypeParam> volume(n, noise);
      const std::string whole = volume.store();
      for (const uint32_t count : {1u, 2u, 3u, 7u, 19u}) {
        if (noise > 0 && count % 3 != 1) continue;
        SCOPED_TRACE(testing::Message() << n.x << " x " << n.y << " x " << n.z << ", noise "
                                        << noise << ", " << count << " parts");
        const TemporaryFolder folder;
        BuildOptions options;
        options.threads = 1 + count % 3;
        const Joined joined = join(volume, build_parts(volume, folder, count, options), options);
        EXPECT_EQ(joined.error, "");
        EXPECT_TRUE(joined.store == whole);
        const uint64_t blocks = level_grid(n, 0).block_count();
        EXPECT_EQ(joined.taken + joined.changed, blocks);
        const bool is_small = noise == 0 && sizeof(TypeParam) == 1;
        EXPECT_TRUE(!is_small || joined.changed == 0) << joined.changed;
      }
    }
  }
}

/// A source that cannot be read, since its join must not.
class Unread : public ArraySource<uint8_t> {
 public:
  using ArraySource::ArraySource;
  Result<void> read_slices(int32_t first, int32_t count, std::span<std::byte> out) override {
    slices += count;
    return ArraySource::read_slices(first, count, out);
  }
  int64_t slices = 0;
};

TEST(Parts, JoiningReadsOnlyTheSampleOfTheVolume) {
  const Index3 n{150, 140, 700};
  const std::vector<uint8_t> voxels = waves<uint8_t>(n, 0);
  const Volume<uint8_t> volume(n, 0);
  const TemporaryFolder folder;
  auto kept = KeptBlocks::of_parts(build_parts(volume, folder, 3));
  ASSERT_TRUE(kept);
  Unread source(volume.grid, std::span<const uint8_t>(voxels));
  MemorySink sink;
  BuildOptions options;
  options.kept = kept->get();
  ASSERT_TRUE(build_store(source, sink, options));
  EXPECT_LT(source.slices, n.z / 2);
}

TEST(Parts, OptionsThatChangeTheStoreReachAllParts) {
  const Volume<float> volume({100, 90, 140}, 0.3);
  BuildOptions options;
  options.range = ValueRange{40, 150};
  options.fetch_weight = 4;
  options.title = "waves";
  const TemporaryFolder folder;
  const auto parts = build_parts(volume, folder, 3, options);
  EXPECT_TRUE(join(volume, parts, options).store == volume.store(options));
  for (int changed = 0; changed < 3; ++changed) {
    BuildOptions other = options;
    if (changed == 0) other.range = ValueRange{40, 151};
    if (changed == 1) other.fetch_weight = 2;
    if (changed == 2) other.title = "others";
    const Joined joined = join(volume, parts, other);
    EXPECT_NE(joined.error.find("found a part of another build"), std::string::npos)
        << changed << joined.error;
  }
  EXPECT_NE(join(Volume<float>({100, 90, 140}, 0.31), parts, options).error, "");
}

TEST(Parts, WrongPartsAreNamed) {
  const Volume<uint8_t> volume({130, 70, 130});
  const TemporaryFolder folder, other_folder;
  const auto parts = build_parts(volume, folder, 3);
  const auto expect_error = [&](std::vector<std::filesystem::path> given, const char* why) {
    const Joined joined = join(volume, given);
    EXPECT_NE(joined.error.find(why), std::string::npos) << joined.error;
    EXPECT_EQ(joined.error.find('\n'), std::string::npos);
  };
  expect_error({}, "found none");
  expect_error({parts[0], parts[2]}, "expected 3 parts, found 2: build part 2");
  const auto copy = folder.path() / "copy";
  std::filesystem::copy_file(parts[1], copy);
  expect_error({parts[0], parts[1], parts[2], copy}, "found part 2 of 3 twice");
  const auto of_two = build_parts(volume, other_folder, 2);
  expect_error({parts[0], parts[1], parts[2], of_two[0]}, "remove the parts of other builds");
  const TemporaryFolder foreign;
  const auto others = build_parts(Volume<uint8_t>({130, 70, 130}, 0.1), foreign, 3);
  expect_error({parts[0], parts[1], others[2]}, "another volume or with other options");
  expect_error({others[0], others[1], others[2]}, "found a part of another build");
  const auto text = folder.path() / "text";
  write_file(text, "no part");
  expect_error({parts[0], parts[1], text}, "expected a part of a build");
}

TEST(Parts, EveryDamageIsFound) {
  const Volume<uint8_t> volume({70, 66, 10});
  const std::string whole = volume.store();
  const TemporaryFolder folder;
  const auto parts = build_parts(volume, folder, 2);
  const std::string bytes = read_file(parts[0]);
  const auto expect_found = [&](const std::string& damaged, size_t at) {
    write_file(parts[0], damaged);
    const Joined joined = join(volume, parts);
    EXPECT_TRUE(joined.error != "" || joined.store == whole) << at;
    EXPECT_NE(joined.error, "") << at;
  };
  std::mt19937 random(3);
  for (size_t i = 0; i < 150; ++i) {
    const size_t at = i < 80 ? i : random() % bytes.size();
    std::string damaged = bytes;
    damaged[at] = static_cast<char>(damaged[at] ^ (1 << i % 8));
    expect_found(damaged, at);
    expect_found(bytes.substr(0, at), at);
  }
  expect_found(bytes + "x", bytes.size());
  write_file(parts[0], bytes);
  EXPECT_TRUE(join(volume, parts).store == whole);
}

TEST(Parts, ThereIsNoPartZeroAndNoneAfterTheLast) {
  const Volume<uint8_t> volume({20, 20, 20});
  const TemporaryFolder folder;
  for (const Part part : {Part{0, 3}, Part{4, 3}}) {
    ArraySource<uint8_t> source = volume.source();
    const auto built = build_part_file(source, folder.path() / "part", {}, part);
    ASSERT_FALSE(built);
    EXPECT_EQ(built.error().status, Status::invalid_argument);
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

template <class T>
Joined resume(const Volume<T>& volume, const std::filesystem::path& file,
              const BuildOptions& options = {}) {
  return build_with(volume, KeptBlocks::of_interrupted(file), options);
}

TEST(Resume, ContinuesFromAnyLengthOfItsFile) {
  for (const double noise : {0.0, 0.6}) {
    const Volume<int16_t> volume({70, 70, 195}, noise);
    const std::string whole = volume.store();
    const TemporaryFolder folder;
    const auto file = folder.path() / "unfinished";
    EXPECT_TRUE(resume(volume, file).store == whole);
    const std::string bytes = read_file(file);
    const Joined again = resume(volume, file);
    EXPECT_TRUE(again.store == whole);
    EXPECT_GT(again.taken, 16u);  // all blocks, of all levels
    EXPECT_EQ(again.changed, 0u);
    EXPECT_EQ(read_file(file).size(), bytes.size());
    std::mt19937 random(1);
    uint64_t taken = 0;
    for (int i = 0; i < 30; ++i) {
      std::string part = bytes.substr(0, random() % bytes.size());
      // After a power failure, blocks before the end may not have reached the disk.
      if (i % 3 == 0 && part.size() > 60) part[random() % part.size()] ^= 0x10;
      write_file(file, part);
      const Joined resumed = resume(volume, file);
      const bool is_unknown = part.size() >= 8 && !part.starts_with("\x89ISOP\r\n\x1a");
      EXPECT_TRUE(is_unknown || resumed.store == whole) << resumed.error;
      taken += resumed.taken;
      if (is_unknown) continue;
      const Joined once_more = resume(volume, file);
      EXPECT_TRUE(once_more.store == whole);
      EXPECT_EQ(once_more.taken, again.taken);
    }
    EXPECT_GT(taken, 30u);
  }
}

TEST(Resume, OtherVolumesAndOptionsBeginAnew) {
  const Volume<uint8_t> volume({70, 70, 130}), other({70, 70, 130}, 0.1);
  const TemporaryFolder folder;
  const auto file = folder.path() / "unfinished";
  resume(volume, file);
  EXPECT_GT(resume(volume, file).taken, 0u);
  const Joined others = resume(other, file);
  EXPECT_EQ(others.taken, 0u);
  EXPECT_TRUE(others.store == other.store());
  EXPECT_GT(resume(other, file).taken, 0u);
  BuildOptions options;
  options.content_key = "another time of modification";
  EXPECT_EQ(resume(other, file, options).taken, 0u);
  options.fetch_weight = 0.5;
  const Joined lighter = resume(other, file, options);
  EXPECT_EQ(lighter.taken, 0u);
  EXPECT_TRUE(lighter.store == other.store(options));
}

TEST(Resume, OtherFilesAreLeftAlone) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "unfinished";
  write_file(file, "a text");
  const auto kept = KeptBlocks::of_interrupted(file);
  ASSERT_FALSE(kept);
  EXPECT_EQ(kept.error().status, Status::invalid_argument);
  EXPECT_EQ(read_file(file), "a text");
}

TEST(Resume, OneBuildAtATimeUsesAFile) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "unfinished";
  const auto first = KeptBlocks::of_interrupted(file);
  ASSERT_TRUE(first);
  const auto second = KeptBlocks::of_interrupted(file);
  ASSERT_FALSE(second);
  EXPECT_NE(second.error().message.find("another process builds this store"), std::string::npos);
}

}  // namespace
}  // namespace isosplat
