// Builds of several stores on the command line: steps that do not fit together, scenes that could
// not be read, and the step of a scene that commands take when none is chosen.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <set>

#include "shared/system/scene_file/scene_file.h"
#include "tests/native/cli_program.h"

namespace isosplat {
namespace {

using test::Ended;
using test::read_file;
using test::run;
using test::TempFolder;
using test::write_file;

constexpr int kEdge = 20;

class CliSteps : public ::testing::Test {
 protected:
  std::string write_nrrd(const std::string& name, const std::function<int(int)>& voxel,
                         const std::string& type = "uint16") {
    return test::write_cube(folder, name, type, kEdge, test::cube<uint16_t>(kEdge, voxel));
  }

  std::string write_nifti(const std::string& name, float slope) {
    std::string header(352, '\0');
    const auto put = [&](size_t at, auto value) { std::memcpy(&header[at], &value, sizeof value); };
    put(0, int32_t{348});
    put(40, std::array<int16_t, 4>{3, kEdge, kEdge, kEdge});
    put(70, std::array<int16_t, 2>{4, 16});  // 16-bit integers
    put(76, std::array<float, 4>{1, 1, 1, 1});
    put(108, std::array<float, 3>{352, slope, 0});
    put(344, std::array<char, 4>{'n', '+', '1', '\0'});
    const std::string path = folder / name;
    write_file(path, header + test::cube<uint16_t>(kEdge, [](int i) { return i % 700; }));
    return path;
  }

  /// The different mappings of a scene's stores, as text.
  static std::set<std::string> mappings(const std::filesystem::path& path) {
    std::set<std::string> found;
    const auto file = SceneFile::open(path);
    EXPECT_TRUE(file) << file.error().message;
    if (!file) return found;
    for (const std::string& store : store_paths(file->scene())) {
      const auto opened = file->open_store(store);
      EXPECT_TRUE(opened) << opened.error().message;
      const ValueMapping& mapping = (*opened)->info().mapping;
      found.insert(fmt::format("{} {} {}", mapping.offset, mapping.scale, mapping.bits));
    }
    return found;
  }

  const TempFolder folder;
  const std::string output = folder / "run.isobundle";
  const std::string kept_apart = "has another type or scale of values than the first step";
};

TEST_F(CliSteps, AFurtherStepThatChangesTheMappingBuildsTheOthersAgain) {
  struct Case {
    std::vector<std::string> options;
    std::function<int(int)> first, further;
  };
  const std::vector<Case> cases{
      // The differences of the first steps have no common divisor above 1. The range of all steps
      // matters because of --max-error.
      {{"--max-error", "2"}, [](int i) { return 1000 + i % 700; }, [](int i) { return i % 1700; }},
      // The range is the same, but the common divisor of the differences is not.
      {{}, [](int i) { return i % 200 * 4; }, [](int i) { return i % 399 * 2; }},
  };
  for (size_t i = 0; i < cases.size(); ++i) {
    SCOPED_TRACE(i);
    const std::string run_folder = folder / fmt::format("run{}", i);
    std::vector<std::string> call = cases[i].options;
    call.insert(call.begin(), {"build", "-o", run_folder + "/"});
    for (const char* name : {"a1.nrrd", "a2.nrrd"}) {
      call.push_back(write_nrrd(name, cases[i].first));
    }
    ASSERT_EQ(run(call).exit_code, 0);
    call.push_back(write_nrrd("a3.nrrd", cases[i].further));
    const Ended more = run(call);
    ASSERT_EQ(more.exit_code, 0) << more.err;
    EXPECT_EQ(mappings(run_folder + "/scene.json").size(), 1u);
  }
}

TEST_F(CliSteps, AStepOfAnotherTypeIsNoted) {
  // The first step alone decides how 16-bit integers are stored.
  const auto first = write_nrrd("a1.nrrd", [](int i) { return i % 700; });
  const auto second = write_nrrd(
      "a2.nrrd", [](int i) { return i % 700 - 5; }, "int16");
  const Ended built = run({"build", first, second, "-o", output});
  EXPECT_EQ(built.exit_code, 0) << built.err;
  EXPECT_NE(built.err.find(kept_apart), std::string::npos) << built.err;
}

TEST_F(CliSteps, AStepOfAnotherScaleIsNoted) {
  const auto first = write_nifti("a1.nii", 1), second = write_nifti("a2.nii", 0.37f);
  const Ended built = run({"build", first, second, "-o", output});
  EXPECT_EQ(built.exit_code, 0) << built.err;
  EXPECT_NE(built.err.find(kept_apart), std::string::npos) << built.err;
  const Ended same = run({"build", first, write_nifti("a3.nii", 1), "-o", output});
  EXPECT_EQ(same.exit_code, 0) << same.err;
  EXPECT_EQ(same.err.find(kept_apart), std::string::npos) << same.err;
}

TEST_F(CliSteps, ASceneThatCouldNotBeReadIsRefusedBeforeItsStoresAreBuilt) {
  const auto voxel = [](int i) { return i % 700; };
  const auto first = write_nrrd("a1.nrrd", voxel), second = write_nrrd("a2.nrrd", voxel);
  const std::string list = folder / "steps.txt";
  write_file(list, "0 a1.nrrd\n1e305 a2.nrrd\n");
  const std::vector<std::vector<std::string>> calls{
      {"build", first, second, "--time-unit", std::string(65, 's')}, {"build", "--steps", list}};
  for (std::vector<std::string> call : calls) {
    call.insert(call.end(), {"-o", ""});
    for (const std::string& to : {std::string(folder / "run/"), output}) {
      call.back() = to;
      const Ended refused = run(call);
      EXPECT_NE(refused.exit_code, 0);
      EXPECT_NE(refused.err.find("scene: time."), std::string::npos) << refused.err;
    }
  }
  EXPECT_FALSE(std::filesystem::exists(output));
  EXPECT_FALSE(std::filesystem::exists(folder / "run"));
  EXPECT_FALSE(std::filesystem::exists(folder / ".run.isobundle.parts"));
}

TEST_F(CliSteps, NoTimeStepsOfAFileAreLeftOut) {
  const std::string path = folder / "long.nrrd";
  write_file(path,
             "NRRD0004\ntype: uint8\ndimension: 4\nsizes: 2 2 2 10001\n"
             "kinds: space space space time\nencoding: raw\n\n" +
                 std::string(size_t{8} * 10001, 'x'));
  const Ended refused = run({"build", path, "-o", output});
  EXPECT_NE(refused.exit_code, 0);
  EXPECT_NE(refused.err.find("fewer than 10000"), std::string::npos) << refused.err.substr(0, 500);
}

TEST_F(CliSteps, AFolderDoesNotContainThePathsOfItsInputs) {
  const auto voxel = [](int i) { return i % 700; };
  const auto first = write_nrrd("a1.nrrd", voxel), second = write_nrrd("a2.nrrd", voxel);
  const auto built = run(test::Call{.arguments = {"build", first, second, "-o", folder / "run/"},
                                    .draws_thumbnails = true});
  ASSERT_EQ(built.exit_code, 0) << built.err;
  const std::string inputs = std::filesystem::path(first).parent_path();
  size_t files = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder / "run")) {
    if (!entry.is_regular_file()) continue;
    ++files;
    EXPECT_EQ(read_file(entry.path()).find(inputs), std::string::npos) << entry.path();
  }
  EXPECT_EQ(files, 5u);  // a scene with its picture, two stores, and their keys
}

TEST_F(CliSteps, CommandsTakeTheStepThatTheSceneShowsFirst) {
  for (int step = 0; step < 2; ++step) {
    write_nrrd(fmt::format("s{}.nrrd", step), [&](int i) {
      const double x = i % kEdge - 9.5, y = i / kEdge % kEdge - 9.5, z = i / kEdge / kEdge - 9.5;
      return std::max(
          0, static_cast<int>(200 - std::sqrt(x * x + y * y + z * z) * (step == 0 ? 20 : 40)));
    });
  }
  const std::string run_folder = folder / "run/", document = run_folder + "scene.json";
  ASSERT_EQ(run({"build", folder / "s0.nrrd", folder / "s1.nrrd", "-o", run_folder}).exit_code, 0);
  const auto picture = [&](const std::vector<std::string>& more) {
    std::vector<std::string> call{"render", document, "-o",      folder / "x.png",
                                  "--size", "64x64",  "--force", "--aliased"};
    call.insert(call.end(), more.begin(), more.end());
    const Ended drawn = run(call);
    EXPECT_EQ(drawn.exit_code, 0) << drawn.err;
    return read_file(folder / "x.png");
  };
  const auto points = [&](const std::vector<std::string>& more) {
    std::vector<std::string> call{"extract", document, "-o", folder / "x.ply", "--force"};
    call.insert(call.end(), more.begin(), more.end());
    const Ended extracted = run(call);
    EXPECT_EQ(extracted.exit_code, 0) << extracted.err;
    return extracted.out;  // with their number
  };
  const std::string first_points = points({"--step", "0"}), second_points = points({"--step", "1"});
  EXPECT_NE(first_points, second_points);
  EXPECT_EQ(points({}), first_points);
  const std::string first = picture({"--step", "0"});
  const std::string second = picture({"--step", "1"});
  EXPECT_NE(first, second);
  EXPECT_EQ(picture({}), first);
  std::string text = read_file(document);
  write_file(document, text.insert(text.find("\"steps\""), "\"step\": 1, "));
  EXPECT_EQ(picture({}), second);
  EXPECT_EQ(picture({"--step", "0"}), first);
  EXPECT_EQ(points({}), second_points);
  const Ended info = run({"info", document});
  EXPECT_NE(info.out.find("volume_00001.isosplat and 1 more"), std::string::npos) << info.out;
}

}  // namespace
}  // namespace isosplat
