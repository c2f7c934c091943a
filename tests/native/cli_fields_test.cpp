// isosplat build --field.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/native/cli_program.h"

namespace isosplat {
namespace {

using test::Ended;
using test::run;
using test::TempFolder;

class CliFields : public ::testing::Test {
 protected:
  Ended build(const std::vector<std::string>& options) {
    std::vector<std::string> arguments{"build", volume, "-o", store, "--no-thumbnail"};
    arguments.insert(arguments.end(), options.begin(), options.end());
    return run(arguments);
  }

  const TempFolder folder;
  const std::string store = folder / "x.isosplat", volume = test::write_ball(folder, 24);
  const std::string field = test::write_cube(
      folder, "t.nrrd", "int16", 24, test::cube<int16_t>(24, [](int i) { return i % 24 - 300; }));
};

TEST_F(CliFields, AreBuiltDescribedAndVerified) {
  const Ended built = build({"--field", "temperature=" + field, "--field", "same=" + volume});
  ASSERT_EQ(built.exit_code, 0) << built.err;
  EXPECT_NE(built.out.find("Field temperature: "), std::string::npos) << built.out;
  const Ended verified = run({"verify", store});
  EXPECT_EQ(verified.exit_code, 0) << verified.err;
  EXPECT_NE(verified.out.find(" chunks of 2 fields"), std::string::npos) << verified.out;
  const Ended info = run({"info", store});
  EXPECT_NE(info.out.find("temperature: -300 to -277, lossless"), std::string::npos) << info.out;
  const auto json = nlohmann::json::parse(run({"info", store, "--json"}).out);
  ASSERT_EQ(json["fields"].size(), 2u);
  EXPECT_EQ(json["fields"][0]["name"], "temperature");
  EXPECT_EQ(json["fields"][0]["range"], (nlohmann::json{-300.0, -277.0}));
  EXPECT_EQ(json["fields"][1]["mapping"]["maxError"], 0.0);
  const auto queries = nlohmann::json::parse(
      run({"info", store, "--chunks", "--json"}).out)["chunkReport"]["queries"];
  uint64_t active = 0;
  for (const auto& query : queries) {
    active += query["activeCells"].get<uint64_t>();
    EXPECT_EQ(query["fieldBytes"]["temperature"].get<uint64_t>() > 0, query["chunks"] > 0);
  }
  EXPECT_GT(active, 0u);
}

TEST_F(CliFields, RefusesWhatItCannotBuild) {
  const auto expect_refused = [&](const std::vector<std::string>& options,
                                  const std::string& message) {
    const Ended refused = build(options);
    EXPECT_NE(refused.exit_code, 0);
    EXPECT_NE(refused.err.find(message), std::string::npos) << refused.err;
    EXPECT_FALSE(std::filesystem::exists(store));
  };
  const std::string small = test::write_cube(folder, "s.nrrd", "uint8", 5,
                                             test::cube<uint8_t>(5, [](int i) { return i; }));
  expect_refused({"--field", "t=" + small}, "expected 24 × 24 × 24 voxels");
  expect_refused({"--field", field}, "expected a name and a volume");
  expect_refused({"--field", "a b=" + field}, "expected a name of at most 64 letters");
  expect_refused({"--field", "t=" + std::string(folder / "none.nrrd")}, "none.nrrd");
  expect_refused({"--field", "t=" + field, "--resume"}, "found a scene, --resume or --part");
  expect_refused({"--field", "t=" + field, "--part", "1/2"}, "found a scene, --resume or --part");
  const Ended overwritten =
      run({"build", volume, "-o", field, "--force", "--no-thumbnail", "--field", "t=" + field});
  EXPECT_NE(overwritten.exit_code, 0);
  EXPECT_EQ(run({"info", field}).exit_code, 0);
}

}  // namespace
}  // namespace isosplat
