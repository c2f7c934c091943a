// isosplat extract of scenes and bundles.

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "tests/native/cli_program.h"

namespace isosplat {
namespace {

using test::Ended;
using test::read_file;
using test::run;
using test::TempFolder;
using test::write_ball;
using test::write_file;
using Json = nlohmann::json;

/// Three layers: a ball, the same ball mirrored and moved along x, with two surfaces, and a hidden
/// ball.
class CliExtractScene : public ::testing::Test {
 protected:
  CliExtractScene() {
    const Ended built =
        run({"build", write_ball(folder, 24, "ball"), "-o", store, "--no-thumbnail"});
    EXPECT_EQ(built.exit_code, 0) << built.err;
    write_scene(Json::object());
  }

  void write_scene(const Json& changes) {
    Json json = {{"format", "isosplat-scene"},
                 {"version", 1},
                 {"layers",
                  {{{"name", "left"},
                    {"store", "ball.isosplat"},
                    {"surfaces", {{{"isovalue", 100}, {"colour", "#ff0000"}}}}},
                   {{"name", "right/..: *"},
                    {"store", "ball.isosplat"},
                    {"transform", {-1, 0, 0, 90, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}},
                    {"surfaces", {{{"isovalue", 100}}, {{"isovalue", 130}, {"opacity", 0.5}}}}},
                   {{"name", "hidden"},
                    {"store", "ball.isosplat"},
                    {"surfaces", {{{"isovalue", 90}}}},
                    {"visible", false}}}}};
    json.merge_patch(changes);
    write_file(scene, json.dump());
  }

  Ended extract(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"extract", scene.string()});
    return run(arguments);
  }

  std::vector<std::string> files() const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(out)) {
      names.push_back(entry.path().filename());
    }
    std::ranges::sort(names);
    return names;
  }

  const TempFolder folder;
  const std::filesystem::path store = folder / "ball.isosplat", scene = folder / "scene.json";
  const std::filesystem::path out = [this] {
    std::filesystem::create_directory(folder / "out");
    return folder / "out";
  }();
};

Json glb_scene(const std::string& bytes) {
  uint32_t length = 0;
  std::memcpy(&length, bytes.data() + 12, 4);
  return Json::parse(bytes.substr(20, length));
}

TEST_F(CliExtractScene, OneFileHasAllVisibleSurfacesAtTheirPositions) {
  const Ended ended = extract({"--mesh", "-o", out / "balls.glb"});
  ASSERT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_NE(ended.out.find("3 surfaces"), std::string::npos) << ended.out;
  const std::string bytes = read_file(out / "balls.glb");
  const Json json = glb_scene(bytes);
  ASSERT_EQ(json["meshes"].size(), 3u);
  EXPECT_EQ(json["meshes"][0]["name"], "left");
  EXPECT_EQ(json["meshes"][1]["name"], "right/..: * 100");
  EXPECT_EQ(json["meshes"][2]["name"], "right/..: * 130");
  EXPECT_EQ(json["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"], Json({1, 0, 0, 1}));
  EXPECT_EQ(json["materials"][2]["pbrMetallicRoughness"]["baseColorFactor"][3], 0.5);
  const auto position = [&](size_t mesh) {
    return json["accessors"]
               [json["meshes"][mesh]["primitives"][0]["attributes"]["POSITION"].get<size_t>()];
  };
  const double low = position(0)["min"][0], high = position(0)["max"][0];
  EXPECT_NEAR(position(1)["min"][0], 90 - high, 1e-4);
  EXPECT_NEAR(position(1)["max"][0], 90 - low, 1e-4);
}

/// The signed volume that a mesh in a binary STL file encloses. The sign depends on the orientation
/// of its triangles.
double volume_of(const std::string& stl) {
  uint32_t count = 0;
  std::memcpy(&count, stl.data() + 80, 4);
  EXPECT_EQ(stl.size(), 84 + 50 * size_t{count});
  double volume = 0;
  for (size_t i = 0; i < count; ++i) {
    float v[9];
    std::memcpy(v, stl.data() + 84 + 50 * i + 12, sizeof v);
    volume += (double{v[0]} * (double{v[4]} * v[8] - double{v[5]} * v[7]) -
               double{v[1]} * (double{v[3]} * v[8] - double{v[5]} * v[6]) +
               double{v[2]} * (double{v[3]} * v[7] - double{v[4]} * v[6])) /
              6;
  }
  return volume;
}

TEST_F(CliExtractScene, OtherFormatsGetAFileForEachSurface) {
  const Ended ended = extract({"--mesh", "-o", out / "balls.stl"});
  ASSERT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_EQ(files(), (std::vector<std::string>{"balls-left.stl", "balls-right_..____100.stl",
                                               "balls-right_..____130.stl"}));
  // The triangles of a mirrored mesh are reversed, so that they face outwards again.
  const double left = volume_of(read_file(out / "balls-left.stl"));
  const double right = volume_of(read_file(out / "balls-right_..____100.stl"));
  EXPECT_GT(std::abs(left), 100);
  EXPECT_NEAR(left, right, 1e-3 * std::abs(left));
}

TEST_F(CliExtractScene, ChosenLayersNeedNotBeVisible) {
  const Ended ended = extract({"--layer", "hidden", "-o", out / "points.ply"});
  ASSERT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_EQ(files(), std::vector<std::string>{"points.ply"});
  EXPECT_NE(ended.out.find("points with normals"), std::string::npos) << ended.out;
  const Ended by_index = extract({"--layer", "2", "-o", out / "same.ply"});
  ASSERT_EQ(by_index.exit_code, 0) << by_index.err;
  EXPECT_EQ(read_file(out / "same.ply"), read_file(out / "points.ply"));
  const Ended unknown = extract({"--layer", "liver", "-o", out / "none.ply"});
  EXPECT_EQ(unknown.exit_code, 1);
  EXPECT_NE(unknown.err.find("'liver'"), std::string::npos) << unknown.err;
}

TEST_F(CliExtractScene, ABundleGivesTheSameBytes) {
  ASSERT_EQ(extract({"--mesh", "-o", out / "a.obj"}).exit_code, 0);
  const auto bundle = folder / "scene.isobundle";
  ASSERT_EQ(run({"bundle", scene, "-o", bundle}).exit_code, 0);
  const Ended ended = run({"extract", bundle, "--mesh", "-o", out / "b.obj"});
  ASSERT_EQ(ended.exit_code, 0) << ended.err;
  const auto from_second_line = [](const std::string& text) {
    return text.substr(text.find('\n'));
  };
  EXPECT_EQ(from_second_line(read_file(out / "a.obj")), from_second_line(read_file(out / "b.obj")));
}

TEST_F(CliExtractScene, RefusesOptionsThatDoNotFitTheScene) {
  const Ended isovalue = extract({"-i", "100", "-o", out / "a.ply"});
  EXPECT_EQ(isovalue.exit_code, 2);
  EXPECT_NE(isovalue.err.find("scene"), std::string::npos) << isovalue.err;
  const Ended step = extract({"--step", "1", "-o", out / "a.ply"});
  EXPECT_NE(step.err.find("expected a time step from 0 to 0, found 1"), std::string::npos)
      << step.err;
  EXPECT_EQ(run({"extract", store, "-o", out / "a.ply"}).exit_code, 2);
  EXPECT_EQ(run({"extract", store, "-i", "100", "--layer", "a", "-o", out / "a.ply"}).exit_code, 2);
  write_file(out / "a-left.ply", "something else");
  EXPECT_EQ(extract({"-o", out / "a.ply"}).exit_code, 2);
  EXPECT_EQ(files(), std::vector<std::string>{"a-left.ply"});
  write_scene({{"layers", {{{"name", "gone"}, {"store", "gone.isosplat"}}}}});
  const Ended gone = extract({"-o", out / "b.ply"});
  EXPECT_EQ(gone.exit_code, 1);
  EXPECT_NE(gone.err.find("layer 0 (gone)"), std::string::npos) << gone.err;
}

}  // namespace
}  // namespace isosplat
