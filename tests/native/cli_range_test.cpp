// isosplat build --range.

#include <gtest/gtest.h>

#include <functional>
#include <set>

#include "shared/system/scene_file/scene_file.h"
#include "shared/system/store_file/store_file.h"
#include "tests/native/cli_program.h"

namespace isosplat {
namespace {

using test::Ended;
using test::run;
using test::TempFolder;

constexpr int kEdge = 20;

class CliRange : public ::testing::Test {
 protected:
  template <class T>
  std::string write(const std::string& name, const std::string& type,
                    const std::function<double(int)>& voxel) {
    return test::write_cube(folder, name, type, kEdge, test::cube<T>(kEdge, voxel));
  }

  StoreInfo info_of(const std::string& path) {
    const auto opened = StoreFile::open(path);
    EXPECT_TRUE(opened) << (opened ? "" : opened.error().message);
    return opened ? (*opened)->info() : StoreInfo{};
  }

  static double low(const StoreInfo& info) { return info.mapping.value(info.range.min); }
  static double high(const StoreInfo& info) { return info.mapping.value(info.range.max); }

  const TempFolder folder;
  const std::string store = folder / "x.isosplat";
};

TEST_F(CliRange, IntegersOutsideAreSetToItsEndsAndCounted) {
  const auto volume = write<int16_t>("a.nrrd", "int16", [](int i) { return i - 4000; });
  const Ended built = run({"build", volume, "-o", store, "--range=-100,1000.5", "--no-thumbnail"});
  ASSERT_EQ(built.exit_code, 0) << built.err;
  EXPECT_NE(built.err.find("3,900 voxels below and 2,999 above"), std::string::npos) << built.err;
  const StoreInfo info = info_of(store);
  EXPECT_EQ(low(info), -100);
  EXPECT_EQ(high(info), 1000);
  EXPECT_EQ(info.mapping.scale, 1);
  EXPECT_EQ(info.mapping.max_error, 0);
  EXPECT_EQ(run({"verify", store}).exit_code, 0);
}

TEST_F(CliRange, FloatsAreRoundedOverTheRange) {
  const auto volume = write<float>("a.nrrd", "float", [](int i) {
    return i == 7 ? std::nan("") : i == 8 ? 1e9 : std::sin(i) * 3;
  });
  const Ended built = run({"build", volume, "-o", store, "--range", "-1,2", "--no-thumbnail",
                           "--missing-value", "none"});
  ASSERT_EQ(built.exit_code, 0) << built.err;
  const StoreInfo info = info_of(store);
  EXPECT_NEAR(low(info), -1, 1e-4);
  EXPECT_NEAR(high(info), 2, 1e-4);
  EXPECT_LT(info.mapping.max_error, 3.0 / 65534);
  EXPECT_EQ(info.missing_voxels, 1u);
  // Without a voxel outside, there is no note.
  const Ended wide = run({"build", volume, "-o", store, "--range", "-5,2e9", "--no-thumbnail",
                          "--missing-value", "none"});
  EXPECT_EQ(wide.err.find("--range"), std::string::npos) << wide.err;
}

TEST_F(CliRange, StepsHaveOneMappingWithoutReadingAll) {
  const auto first = write<float>("s1.nrrd", "float", [](int i) { return std::sin(i); });
  const auto second = write<float>("s2.nrrd", "float", [](int i) { return 2 * std::sin(3 * i); });
  const std::string output = folder / "run.isobundle";
  const Ended built = run({"build", first, second, "-o", output, "--range", "-1.5,1.5"});
  ASSERT_EQ(built.exit_code, 0) << built.err;
  EXPECT_NE(built.err.find("--range: "), std::string::npos) << built.err;
  EXPECT_EQ(built.err.find("reading the values of step"), std::string::npos) << built.err;
  const auto file = SceneFile::open(output);
  ASSERT_TRUE(file);
  std::set<std::string> mappings;
  for (const std::string& path : store_paths(file->scene())) {
    const auto opened = file->open_store(path);
    ASSERT_TRUE(opened);
    const ValueMapping& mapping = (*opened)->info().mapping;
    mappings.insert(fmt::format("{} {} {}", mapping.offset, mapping.scale, mapping.bits));
  }
  EXPECT_EQ(mappings.size(), 1u);
}

TEST_F(CliRange, ImpossibleRangesAreRefused) {
  const auto volume = write<uint8_t>("a.nrrd", "uint8", [](int i) { return i % 200; });
  const auto refuses = [&](const std::vector<std::string>& more, const char* expected) {
    std::vector<std::string> call{"build", volume, "-o", store};
    call.insert(call.end(), more.begin(), more.end());
    const Ended built = run(call);
    EXPECT_NE(built.exit_code, 0);
    EXPECT_NE(built.err.find(expected), std::string::npos) << built.err;
  };
  refuses({"--range", "5,5"}, "the lower one first");
  refuses({"--range", "9,5"}, "the lower one first");
  refuses({"--range", "300,900"}, "expected a range with several values");
  refuses({"--range", "5.2,5.8"}, "expected a range with several values");
  refuses({"--range", "x,5"}, "--range");
  refuses({"--range", "0,5", "--labels"}, "found both");
}

}  // namespace
}  // namespace isosplat
