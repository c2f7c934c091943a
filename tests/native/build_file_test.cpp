#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <random>
#include <set>

#include "native/builder/array_source.h"
#include "native/builder/verify.h"
#include "native/files/output_file.h"
#include "tests/native/temporary_folder.h"

namespace isosplat {
namespace {

VolumeGrid grid_of(Index3 voxels) {
  VolumeGrid grid;
  grid.voxels = voxels;
  return grid;
}

std::vector<uint8_t> noise(Index3 n, uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<uint8_t> voxels(static_cast<size_t>(n.x) * static_cast<size_t>(n.y) *
                              static_cast<size_t>(n.z));
  for (auto& v : voxels) v = static_cast<uint8_t>(random());
  return voxels;
}

std::string content(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::set<std::string> names_in(const std::filesystem::path& folder) {
  std::set<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    names.insert(entry.path().filename().string());
  }
  return names;
}

/// A source that waits in the middle of the volume.
class InterruptedSource : public ArraySource<uint8_t> {
 public:
  using ArraySource::ArraySource;
  std::function<Result<void>()> interrupt;
  Result<void> read_slices(int32_t first, int32_t count, std::span<std::byte> out) override {
    if (++calls_ > 2) {
      if (auto result = interrupt(); !result) return result;
    }
    return ArraySource::read_slices(first, count, out);
  }

 private:
  int calls_ = 0;
};

const Index3 kSize{80, 80, 200};

TEST(BuildFile, AppearsCompleteAndWithoutTemporaryFiles) {
  const TemporaryFolder folder;
  const auto target = folder.path() / "volume.isosplat";
  const auto voxels = noise(kSize, 1);
  const auto report = build_store_file<uint8_t>(grid_of(kSize), voxels, target);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(names_in(folder.path()), std::set<std::string>{"volume.isosplat"});
  EXPECT_EQ(std::filesystem::file_size(target), report->info.file_bytes);
  const auto verified = verify_store_file(target);
  EXPECT_TRUE(verified) << verified.error().message;
  EXPECT_EQ(verified->info.content_id, report->info.content_id);
}

TEST(BuildFile, AFailedBuildLeavesTheOldStoreAndNothingElse) {
  const TemporaryFolder folder;
  const auto target = folder.path() / "volume.isosplat";
  std::ofstream(target) << "old";
  const auto voxels = noise(kSize, 1);
  InterruptedSource source(grid_of(kSize), voxels);
  source.interrupt = [] { return fail(Status::io_error, "cannot read"); };
  const auto report = build_store_file(source, target, {});
  ASSERT_FALSE(report);
  EXPECT_EQ(report.error().message, "cannot read");
  EXPECT_EQ(content(target), "old");
  EXPECT_EQ(names_in(folder.path()), std::set<std::string>{"volume.isosplat"});
}

TEST(BuildFile, AKilledBuildLeavesTheOldStoreAndTheNextCleansUp) {
  const TemporaryFolder folder;
  const auto target = folder.path() / "volume.isosplat";
  std::ofstream(target) << "old";
  const auto voxels = noise(kSize, 1);
  const pid_t child = ::fork();
  if (child == 0) {
    InterruptedSource source(grid_of(kSize), voxels);
    source.interrupt = []() -> Result<void> {
      ::raise(SIGKILL);
      return {};
    };
    BuildOptions options;
    options.threads = 1;
    (void)build_store_file(source, target, options);
    ::_exit(0);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  ASSERT_TRUE(WIFSIGNALED(status));
  EXPECT_EQ(content(target), "old");
  EXPECT_EQ(names_in(folder.path()).size(), 2u);  // the target, and the killed build's file
  // The temporary file of a running build, and other files, are not removed.
  auto live = OutputFile::create(target);
  ASSERT_TRUE(live);
  std::ofstream(folder.path() / ".other.isosplat.building-123456") << "other";
  EXPECT_EQ(names_in(folder.path()).size(), 3u);
  ASSERT_TRUE(build_store_file<uint8_t>(grid_of(kSize), voxels, target));
  EXPECT_EQ(names_in(folder.path()),
            (std::set<std::string>{"volume.isosplat", ".other.isosplat.building-123456",
                                   live->temporary_path().filename().string()}));
  EXPECT_TRUE(verify_store_file(target));
}

TEST(BuildFile, AFullDiskIsOneClearError) {
  const TemporaryFolder folder;
  const auto target = folder.path() / "volume.isosplat";
  std::ofstream(target) << "old";
  const auto voxels = noise(kSize, 1);
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  ::getrlimit(RLIMIT_FSIZE, &before);
  const rlimit little{100000, before.rlim_max};
  ::setrlimit(RLIMIT_FSIZE, &little);
  const auto report = build_store_file<uint8_t>(grid_of(kSize), voxels, target);
  ::setrlimit(RLIMIT_FSIZE, &before);
  ASSERT_FALSE(report);
  EXPECT_EQ(report.error().status, Status::io_error);
  EXPECT_NE(report.error().message.find("free some space"), std::string::npos);
  EXPECT_EQ(content(target), "old");
  EXPECT_EQ(names_in(folder.path()), std::set<std::string>{"volume.isosplat"});
}

/// A volume that is generated slice by slice: a ramp with large constant parts.
class ComputedSource : public VolumeSource {
 public:
  explicit ComputedSource(Index3 n) : header_{grid_of(n), VoxelType::u8, "computed", "ramp"} {}
  const VolumeHeader& header() const override { return header_; }
  Result<void> read_slices(int32_t first, int32_t count, std::span<std::byte> out) override {
    const size_t slice = out.size() / static_cast<size_t>(count);
    for (size_t i = 0; i < out.size(); ++i) {
      const size_t z = static_cast<size_t>(first) + i / slice;
      out[i] = static_cast<std::byte>(std::min<size_t>(255, (i % slice / 4096 + z) / 8));
    }
    return {};
  }
  uint64_t resident_bytes() const override { return 0; }
  std::vector<std::filesystem::path> files() const override { return {}; }

 private:
  VolumeHeader header_;
};

TEST(BuildFile, StaysWithinItsMemory) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers need memory of their own";
#endif
  const TemporaryFolder folder;
  ComputedSource source({900, 900, 70});
  BuildOptions options;
  options.threads = 2;
  options.memory_bytes = min_memory(source, options);
  const pid_t child = ::fork();
  if (child == 0) {
    const auto report = build_store_file(source, folder.path() / "ramp.isosplat", options);
    ::_exit(report && report->uses_temporary_files ? 0 : 1);
  }
  int status = 0;
  rusage usage{};
  ::wait4(child, &status, 0, &usage);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
  EXPECT_LE(static_cast<uint64_t>(usage.ru_maxrss) * 1024, options.memory_bytes);
  EXPECT_GE(static_cast<uint64_t>(usage.ru_maxrss) * 1024, options.memory_bytes / 4);
}

TEST(BuildFile, InvalidTargetsAreRefused) {
  const TemporaryFolder folder;
  const auto voxels = noise({4, 4, 4}, 1);
  EXPECT_EQ(build_store_file<uint8_t>(grid_of({4, 4, 4}), voxels, folder.path()).error().status,
            Status::invalid_argument);
  EXPECT_EQ(build_store_file<uint8_t>(grid_of({4, 4, 4}), voxels, "/dev/null").error().status,
            Status::invalid_argument);
  EXPECT_EQ(build_store_file<uint8_t>(grid_of({4, 4, 4}), voxels, folder.path() / "no" / "where")
                .error()
                .status,
            Status::io_error);
}

}  // namespace
}  // namespace isosplat
