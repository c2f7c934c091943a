// isosplat-mpi, started by mpirun. build_ranks_test.cpp tests builds by several ranks without MPI.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>
#include <thread>

#include "shared/core/grid/grid.h"
#include "tests/native/cli_program.h"

namespace isosplat {
namespace {

using test::Call;
using test::Ended;
using test::read_file;
using test::run;
using test::start;
using test::TempFolder;
using test::wait_for;
using test::write_ball;
using test::write_file;

/// The command that starts isosplat-mpi with these arguments on so many ranks.
Call mpi_call(int ranks, const std::vector<std::string>& arguments) {
  Call call;
#ifdef ISOSPLAT_MPI_PROGRAM
  // Open MPI refuses to run as root otherwise, as in containers.
  setenv("OMPI_ALLOW_RUN_AS_ROOT", "1", 1);
  setenv("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1", 1);
  call.program = ISOSPLAT_MPIRUN;
  call.arguments = {"-n", std::to_string(ranks)};
  if (*ISOSPLAT_MPIRUN_FLAG) call.arguments.push_back(ISOSPLAT_MPIRUN_FLAG);
  call.arguments.push_back(ISOSPLAT_MPI_PROGRAM);
#else
  static_cast<void>(ranks);
#endif
  call.arguments.insert(call.arguments.end(), arguments.begin(), arguments.end());
  return call;
}

class Mpi : public ::testing::Test {
 protected:
  void SetUp() override {
#ifndef ISOSPLAT_MPI_PROGRAM
    GTEST_SKIP() << "isosplat-mpi was not built: install libopenmpi-dev and openmpi-bin, then "
                    "configure again";
#endif
    // Each mpirun keeps its files in a folder of its own: two that start and end at the same time
    // share, and remove, one otherwise.
    setenv("TMPDIR", session_.path().c_str(), 1);
  }
  void TearDown() override {
    unsetenv("TMPDIR");
  }

 private:
  TempFolder session_;
};

template <class T>
std::string waves(Index3 n, double noise) {
  std::mt19937 random(5);
  std::string voxels;
  for (int32_t z = 0; z < n.z; ++z) {
    for (int32_t y = 0; y < n.y; ++y) {
      for (int32_t x = 0; x < n.x; ++x) {
        const double wave = std::sin(0.11 * x) * std::cos(0.07 * y) * std::sin(0.05 * z + 1);
        const double u = static_cast<double>(random()) / 4294967295.0;
        const T voxel = static_cast<T>(100 * (1 + wave) * (1 - noise) + 200 * noise * u);
        voxels.append(reinterpret_cast<const char*>(&voxel), sizeof voxel);
      }
    }
  }
  return voxels;
}

/// Writes a volume as NRRD, and returns its path.
template <class T>
std::string write_waves(const TempFolder& folder, const std::string& type, Index3 n, double noise) {
  const std::string path = folder / ("waves_" + type + ".nrrd");
  write_file(path, fmt::format("NRRD0004\ntype: {}\ndimension: 3\nsizes: {} {} {}\n"
                               "encoding: raw\nendian: little\n\n",
                               type, n.x, n.y, n.z) +
                       waves<T>(n, noise));
  return path;
}

/// Builds with 1, 2, 3, 4 and 7 ranks, and compares the stores with that of isosplat.
void expect_same_stores(const std::string& volume, const TempFolder& folder) {
  const std::string store = folder / "out.isosplat";
  std::filesystem::remove(store);
  const Ended once = run({"build", volume, "-o", store, "--no-thumbnail", "-q"});
  ASSERT_EQ(once.exit_code, 0) << once.err;
  const std::string whole = read_file(store);
  for (const int ranks : {1, 2, 3, 4, 7}) {
    std::filesystem::remove(store);
    const Ended built = run(
        mpi_call(ranks, {"build", volume, "-o", store, "--no-thumbnail", "-q", "--threads", "1"}));
    ASSERT_EQ(built.exit_code, 0) << built.err;
    EXPECT_TRUE(read_file(store) == whole) << ranks << " ranks";
  }
}

TEST_F(Mpi, AnyNumberOfRanksWritesTheStoreOfOneBuild) {
  const TempFolder folder;
  expect_same_stores(write_waves<uint8_t>(folder, "uint8", {141, 150, 131}, 0.02), folder);
  expect_same_stores(write_waves<uint16_t>(folder, "uint16", {131, 66, 200}, 1), folder);
}

TEST_F(Mpi, FloatingPointNumbersAndSmallVolumesToo) {
  const TempFolder folder;
  expect_same_stores(write_waves<float>(folder, "float", {90, 131, 141}, 0.05), folder);
  expect_same_stores(write_waves<double>(folder, "double", {70, 75, 133}, 0.5), folder);
  expect_same_stores(write_waves<int16_t>(folder, "int16", {23, 17, 9}, 0.1), folder);
}

TEST_F(Mpi, PrintsWhatTheProgramPrintsOnce) {
  const TempFolder folder;
  const std::string volume = write_ball(folder, 40);
  const Ended built = run(mpi_call(3, {"build", volume, "--no-thumbnail"}));
  ASSERT_EQ(built.exit_code, 0) << built.err;
  EXPECT_EQ(built.out.find("ball.isosplat: 40 × 40 × 40 voxels"),
            built.out.rfind("ball.isosplat: 40 × 40 × 40 voxels"));
  EXPECT_NE(built.out.find("ball.isosplat: 40 × 40 × 40 voxels"), std::string::npos) << built.out;
  EXPECT_EQ(folder.files(), (std::vector<std::string>{"ball.isosplat", "ball.nrrd"}));
}

/// How many lines of a text are errors of isosplat or isosplat-mpi.
size_t errors_in(const std::string& text) {
  std::istringstream lines(text);
  size_t count = 0;
  for (std::string line; std::getline(lines, line);) {
    count += line.starts_with("isosplat: ") || line.starts_with("isosplat-mpi: ");
  }
  return count;
}

TEST_F(Mpi, ErrorsArePrintedOnce) {
  const TempFolder folder;
  const std::string volume = write_ball(folder, 40);
  for (const std::vector<std::string>& wrong : {std::vector<std::string>{"build"},
                                                {"build", volume, "--memory", "x"},
                                                {"build", folder / "none.nrrd"},
                                                {"build", volume, "-o", folder.path()}}) {
    const Ended ended = run(mpi_call(3, wrong));
    EXPECT_NE(ended.exit_code, 0);
    EXPECT_EQ(errors_in(ended.err), 1u) << ended.err;
  }
  EXPECT_EQ(folder.files(), (std::vector<std::string>{"ball.nrrd"}));
}

TEST_F(Mpi, ATruncatedVolumeLeavesNoStore) {
  const TempFolder folder;
  const std::string volume = write_ball(folder, 140);
  std::filesystem::resize_file(volume, 1'000'000);
  const Ended ended = run(mpi_call(2, {"build", volume}));
  EXPECT_NE(ended.exit_code, 0);
  EXPECT_EQ(errors_in(ended.err), 1u) << ended.err;
  EXPECT_EQ(folder.files(), (std::vector<std::string>{"ball.nrrd"}));
}

TEST_F(Mpi, AFullDiskLeavesNoStore) {
  const TempFolder folder;
  // Open MPI's own files are smaller than this limit, and the store is larger.
  const std::string volume = write_waves<uint16_t>(folder, "uint16", {230, 220, 210}, 1);
  Call call = mpi_call(2, {"build", volume, "-o", folder / "out.isosplat", "--no-thumbnail"});
  call.file_limit = 16'000'000;
  const Ended ended = run(call);
  EXPECT_NE(ended.exit_code, 0);
  EXPECT_EQ(errors_in(ended.err), 1u) << ended.err;
  EXPECT_NE(ended.err.find("out.isosplat"), std::string::npos) << ended.err;
  EXPECT_EQ(folder.files(), (std::vector<std::string>{"waves_uint16.nrrd"}));
}

/// The processes whose parent is `parent`, in the order in which they were started.
std::vector<pid_t> children_of(pid_t parent) {
  std::vector<pid_t> children;
  std::ifstream list(fmt::format("/proc/{0}/task/{0}/children", parent));
  for (pid_t child = 0; list >> child;) children.push_back(child);
  return children;
}

bool has_temporary_file(const TempFolder& folder) {
  for (const std::string& name : folder.files()) {
    if (name.find(".building-") != name.npos) return true;
  }
  return false;
}

/// Kills a rank while it builds. The others end too, and no store is there.
void kill_one(size_t rank, bool leaves_temporary_file) {
  const TempFolder folder, output;
  const std::string volume = write_waves<uint16_t>(folder, "uint16", {300, 300, 300}, 0.3);
  Call call = mpi_call(3, {"build", volume, "-o", output / "out.isosplat", "--no-thumbnail", "-q",
                           "--threads", "1"});
  const pid_t mpirun = start(call, folder / "out", folder / "err");
  while (!has_temporary_file(output)) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  const std::vector<pid_t> ranks = children_of(mpirun);
  if (ranks.size() != 3) {
    ::kill(mpirun, SIGTERM);
    wait_for(mpirun, folder / "out", folder / "err");
    GTEST_SKIP() << "this mpirun does not start the ranks itself";
  }
  ::kill(ranks[rank], SIGKILL);
  const Ended ended = wait_for(mpirun, folder / "out", folder / "err");
  EXPECT_NE(ended.exit_code, 0);
  EXPECT_NE(ended.err.find("signal 9"), std::string::npos) << ended.err;  // mpirun's message
  EXPECT_FALSE(std::filesystem::exists(output / "out.isosplat"));
  EXPECT_EQ(has_temporary_file(output), leaves_temporary_file) << ended.err;
  if (!leaves_temporary_file) return;
  // The next build removes it.
  const Ended again =
      run({"build", write_ball(folder, 20), "-o", output / "out.isosplat", "--no-thumbnail", "-q"});
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_EQ(output.files(), (std::vector<std::string>{"out.isosplat"}));
}

TEST_F(Mpi, AKilledRankEndsAllAndLeavesNoFile) {
  kill_one(1, false);
  kill_one(2, false);
}

TEST_F(Mpi, TheTemporaryFileOfAKilledRank0IsRemovedByTheNextBuild) {
  kill_one(0, true);
}

}  // namespace
}  // namespace isosplat
