#include <chrono>
#include <cstdlib>
#include <random>
#include <thread>

#include "tests/native/cli_program.h"

// isosplat build --part, isosplat join and isosplat build --resume.
namespace isosplat {
namespace {

using test::Call;
using test::cube;
using test::Ended;
using test::read_file;
using test::run;
using test::start;
using test::TempFolder;
using test::wait_for;
using test::write_ball;
using test::write_cube;
using test::write_file;

/// Builds the store of a volume at once, beside it, and returns its bytes.
std::string whole_store(const std::string& volume, const std::filesystem::path& store) {
  const Ended built = run({"build", volume, "-o", store, "--no-thumbnail", "-q"});
  EXPECT_EQ(built.exit_code, 0) << built.err;
  std::string bytes = read_file(store);
  std::filesystem::remove(store);
  return bytes;
}

void expect_error(const Ended& ended, const std::string& why) {
  EXPECT_EQ(ended.exit_code, 2) << ended.err;
  EXPECT_NE(ended.err.find(why), std::string::npos) << ended.err;
  EXPECT_NE(ended.err.find("isosplat: "), std::string::npos) << ended.err;
}

TEST(CliParts, JoinedPartsAreTheStoreOfOneBuild) {
  const TempFolder folder;
  const std::string volume = write_ball(folder, 140);
  const std::string store = folder / "out.isosplat";
  const std::string whole = whole_store(volume, store);
  for (const char* part : {"3/3", "1/3", "2/3"}) {
    const Ended built = run({"build", volume, "-o", store, "--part", part});
    ASSERT_EQ(built.exit_code, 0) << built.err;
    EXPECT_NE(built.out.find("of 27 blocks"), std::string::npos) << built.out;
  }
  EXPECT_FALSE(std::filesystem::exists(store));
  const Ended joined = run({"join", volume, "-o", store, "--no-thumbnail"});
  ASSERT_EQ(joined.exit_code, 0) << joined.err;
  EXPECT_TRUE(read_file(store) == whole);
  EXPECT_TRUE(std::filesystem::exists(store + ".part-2-of-3"));
  const Ended again = run({"join", volume, "-o", store, "--no-thumbnail", "--remove-parts"});
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_TRUE(read_file(store) == whole);
  EXPECT_EQ(folder.files(), (std::vector<std::string>{"ball.nrrd", "out.isosplat"}));
}

TEST(CliParts, WrongPartsAreErrorsAndLeaveNoStore) {
  const TempFolder folder;
  const std::string volume = write_ball(folder, 70);
  const std::string store = folder / "out.isosplat";
  const std::vector<std::string> join{"join", volume, "-o", store};
  expect_error(run(join), "found none: isosplat build VOLUME --part 1/2 builds one");
  for (const char* wrong : {"0/2", "3/2", "1", "/", "1/2000000", "-1/2", "1/2x"}) {
    expect_error(run({"build", volume, "-o", store, std::string("--part=") + wrong}),
                 "expected a part such as 3/16, found '");
  }
  ASSERT_EQ(run({"build", volume, "-o", store, "--part", "1/2"}).exit_code, 0);
  expect_error(run(join), "expected 2 parts, found 1: build part 2");
  ASSERT_EQ(run({"build", volume, "-o", store, "--part", "2/2"}).exit_code, 0);
  expect_error(run({"join", volume, "-o", store, "--fetch-weight", "3"}),
               "found a part of another build");
  expect_error(run({"build", volume, "-o", folder / "run/", "--part", "1/2"}),
               "--part: expected one volume and a store");
  expect_error(run({"build", volume, "-o", folder / "run.isobundle", "--resume"}),
               "--resume: expected one volume and a store");
  ASSERT_EQ(run({"build", volume, "-o", store, "--part", "1/3"}).exit_code, 0);
  expect_error(run(join), "remove the parts of other builds");
  std::filesystem::remove(store + ".part-1-of-3");
  write_file(store + ".part-1-of-2", read_file(store + ".part-1-of-2").substr(0, 1000));
  expect_error(run(join), "build this part again");
  EXPECT_FALSE(std::filesystem::exists(store));
  write_file(store + ".part-1-of-2", "a text of the user");
  expect_error(run({"build", volume, "-o", store, "--part", "1/2"}), "replace it with --force");
}

TEST(CliParts, AKilledBuildIsResumed) {
  const TempFolder folder;
  std::mt19937 random(5);
  const std::string volume =
      write_cube(folder, "noise.nrrd", "uint16", 150, cube<uint16_t>(150, [&](int i) {
                   return static_cast<double>(i % 150 * 8 + i / 22500 + random() % 32);
                 }));
  const std::string store = folder / "out.isosplat";
  const std::vector<std::string> resume{"build", volume,           "-o",      store,
                                        "-q",    "--no-thumbnail", "--resume"};
  const auto begin = std::chrono::steady_clock::now();
  const std::string whole = whole_store(volume, store);
  const auto duration = std::chrono::duration_cast<std::chrono::microseconds>(
      std::chrono::steady_clock::now() - begin);
  // ISOSPLAT_KILLS=50 kills at fifty random moments.
  const char* const kills = std::getenv("ISOSPLAT_KILLS");
  for (int kill_count = kills ? std::atoi(kills) : 5; kill_count > 0; --kill_count) {
    // One to three kills before the build may end.
    for (uint32_t i = 0; i < 1 + random() % 3; ++i) {
      const pid_t child = start(Call{.arguments = resume}, folder / "o", folder / "e");
      std::this_thread::sleep_for(duration * (random() % 1000) / 1000);
      ::kill(child, SIGKILL);
      wait_for(child, folder / "o", folder / "e");
    }
    const Ended ended = run(resume);
    ASSERT_EQ(ended.exit_code, 0) << ended.err;
    ASSERT_TRUE(read_file(store) == whole);
    std::filesystem::remove(folder / "o");
    std::filesystem::remove(folder / "e");
    ASSERT_EQ(folder.files(), (std::vector<std::string>{"noise.nrrd", "out.isosplat"}));
    std::filesystem::remove(store);
  }
}

TEST(CliParts, AResumedBuildTakesTheFinishedBlocks) {
  const TempFolder folder;
  const std::string volume = write_ball(folder, 140);
  const std::string store = folder / "out.isosplat";
  const std::string whole = whole_store(volume, store);
  // A file-size limit above that of the finished blocks of a layer, and below that of the store.
  const std::vector<std::string> resume{"build", volume, "-o", store, "--no-thumbnail", "--resume"};
  const Ended full = run(Call{.arguments = resume, .file_limit = whole.size() + 4'000'000});
  EXPECT_EQ(full.exit_code, 1) << full.err;
  EXPECT_FALSE(std::filesystem::exists(store));
  EXPECT_TRUE(std::filesystem::exists(store + ".unfinished"));
  const Ended resumed = run(resume);
  ASSERT_EQ(resumed.exit_code, 0) << resumed.err;
  EXPECT_NE(resumed.out.find("blocks were complete before"), std::string::npos) << resumed.out;
  EXPECT_TRUE(read_file(store) == whole);
  EXPECT_FALSE(std::filesystem::exists(store + ".unfinished"));
}

}  // namespace
}  // namespace isosplat
