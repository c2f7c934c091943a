// Scenes and bundles on the command line: bundle, unbundle, info, verify, render.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <random>

#include "native/headless/image.h"
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

/// Two stores of balls, and a scene of three layers.
class CliScene : public ::testing::Test {
 protected:
  CliScene() {
    std::filesystem::create_directories(folder / "stores/deep");
    build("stores/one", 24);
    build("stores/deep/two", 40);
    write_file(scene, document());
  }

  void build(const std::string& name, int n) {
    const Ended built = run({"build", write_ball(folder, n, std::filesystem::path(name).filename()),
                             "-o", folder / (name + ".isosplat"), "--no-thumbnail"});
    ASSERT_EQ(built.exit_code, 0) << built.err;
  }

  static std::string document(const std::string& first = "stores/one.isosplat") {
    const Json json = {{"format", "isosplat-scene"},
                       {"version", 1},
                       {"name", "Balls"},
                       {"kept", {{"unknown", true}}},
                       {"layers",
                        {{{"name", "one"},
                          {"store", first},
                          {"surfaces", {{{"isovalue", 100}, {"colour", "#ff0000"}}}}},
                         {{"name", "two"},
                          {"store", "stores/deep/two.isosplat"},
                          {"transform", {1, 0, 0, 60, 0, 1, 0, -8, 0, 0, 1, -16, 0, 0, 0, 1}},
                          {"surfaces", {{{"isovalue", 100}, {"colour", "#0000ff"}}}}},
                         {{"store", first}, {"visible", false}}}}};
    return json.dump(1);
  }

  Ended bundle() { return run({"bundle", scene, "-o", bundle_file}); }

  /// The number of pixels in which this channel has a larger value than the others.
  static int pixels_of(const std::filesystem::path& picture, size_t channel) {
    const auto image = read_png(picture);
    EXPECT_TRUE(image) << image.error().message;
    if (!image) return 0;
    int count = 0;
    for (size_t i = 0; i < image->rgba.size(); i += 4) {
      const auto value = [&](size_t c) { return int(image->rgba[i + c]); };
      const size_t a = (channel + 1) % 3, b = (channel + 2) % 3;
      count += value(channel) > value(a) + 40 && value(channel) > value(b) + 40;
    }
    return count;
  }

  const TempFolder folder;
  const std::filesystem::path scene = folder / "scene.json",
                              bundle_file = folder / "balls.isobundle";
};

TEST_F(CliScene, UnbundlingGivesTheSameBytes) {
  const Ended made = bundle();
  EXPECT_EQ(made.exit_code, 0) << made.err;
  EXPECT_TRUE(made.out.find("3 layers, 2 stores") != std::string::npos) << made.out;
  const auto out = folder / "out";
  const Ended apart = run({"unbundle", bundle_file, "-o", out});
  EXPECT_EQ(apart.exit_code, 0) << apart.err;
  for (const char* name : {"scene.json", "stores/one.isosplat", "stores/deep/two.isosplat"}) {
    EXPECT_EQ(read_file(out / name), read_file(folder / name)) << name;
  }
  const Ended again = run({"unbundle", bundle_file, "-o", out});
  EXPECT_EQ(again.exit_code, 2);
  EXPECT_TRUE(again.err.find("--force") != std::string::npos) << again.err;
  EXPECT_EQ(run({"unbundle", bundle_file, "-o", out, "--force"}).exit_code, 0);
}

/// A bundle of version 1.0, which every later version reads (tests/golden).
TEST_F(CliScene, TheGoldenBundleHoldsTheGoldenStores) {
  const std::filesystem::path golden = std::filesystem::path(ISOSPLAT_SOURCE_DIR) / "tests/golden";
  const auto out = folder / "golden";
  const Ended apart = run({"unbundle", golden / "bundle1.0/golden.isobundle", "-o", out});
  ASSERT_EQ(apart.exit_code, 0) << apart.err;
  EXPECT_EQ(read_file(out / "scene.json"), read_file(golden / "bundle1.0/scene.json"));
  for (const char* name : {"u8.isosplat", "tiny.isosplat"}) {
    EXPECT_EQ(read_file(out / name), read_file(golden / "v1.0" / name)) << name;
  }
  // The same scene gives the same bundle.
  ASSERT_EQ(run({"bundle", out / "scene.json", "-o", out / "again.isobundle"}).exit_code, 0);
  EXPECT_EQ(read_file(out / "again.isobundle"), read_file(golden / "bundle1.0/golden.isobundle"));
}

TEST_F(CliScene, SceneAndBundleAreDescribedAndVerified) {
  ASSERT_EQ(bundle().exit_code, 0);
  for (const auto& path : {scene, bundle_file}) {
    const Ended info = run({"info", path, "--json"});
    ASSERT_EQ(info.exit_code, 0) << info.err;
    const Json json = Json::parse(info.out);
    EXPECT_EQ(json["kind"], path == scene ? "scene" : "bundle");
    EXPECT_EQ(json["name"], "Balls");
    ASSERT_EQ(json["layers"].size(), 3u);
    EXPECT_EQ(json["layers"][1]["voxels"][0], 40);
    EXPECT_EQ(json["layers"][2]["visible"], false);
    EXPECT_EQ(run({"info", path}).exit_code, 0);
    const Ended verified = run({"verify", path});
    EXPECT_EQ(verified.exit_code, 0) << verified.err;
    EXPECT_TRUE(verified.out.find("stores/deep/two.isosplat: valid") != std::string::npos);
  }
}

TEST_F(CliScene, APictureShowsAllVisibleLayersAtTheirPositions) {
  ASSERT_EQ(bundle().exit_code, 0);
  const auto picture = folder / "scene.png", same = folder / "bundle.png";
  const Ended drawn = run({"render", scene, "-o", picture, "--size", "200x150"});
  ASSERT_EQ(drawn.exit_code, 0) << drawn.err;
  EXPECT_GT(pixels_of(picture, 0), 100);
  EXPECT_GT(pixels_of(picture, 2), 100);
  ASSERT_EQ(run({"render", bundle_file, "-o", same, "--size", "200x150"}).exit_code, 0);
  EXPECT_EQ(read_file(picture), read_file(same));
  // Seen from the right, the ball that was moved by 60 to the right hides the other one.
  ASSERT_EQ(run({"render", scene, "-o", picture, "--size", "200x150", "--azimuth", "90",
                 "--elevation", "0", "--force"})
                .exit_code,
            0);
  EXPECT_GT(pixels_of(picture, 2), 100);
  EXPECT_LT(pixels_of(picture, 0), 10);
}

TEST_F(CliScene, APictureHasTheSlicesAndTheLookOfItsScene) {
  const std::string picture = folder / "picture.png";
  const auto draw = [&](const Json& members, std::vector<std::string> options) {
    Json json = Json::parse(document());
    json.update(members);
    write_file(scene, json.dump());
    std::vector<std::string> arguments{"render", scene,     "-o",     picture,
                                       "--size", "200x150", "--force"};
    arguments.insert(arguments.end(), options.begin(), options.end());
    const Ended drawn = run(arguments);
    EXPECT_EQ(drawn.exit_code, 0) << drawn.err;
    const auto image = read_png(picture);
    return image ? image->rgba : std::vector<uint8_t>();
  };
  const auto plain = draw(Json::object(), {});
  ASSERT_FALSE(plain.empty());
  // A look that a scene states gives the same picture as options with the plain scene.
  const Json look = {{"kind", "quad"},
                     {"colour_by", "isovalue"},
                     {"colour_map", "magma"},
                     {"eye_dome", 0},
                     {"light", {{"azimuth", 60}, {"elevation", 10}, {"roughness", 0.9}}}};
  const std::vector<std::string> options{"--kind",     "quad",    "--colour-by",  "isovalue",
                                         "--eye-dome", "0",       "--light",      "60,10",
                                         "--material", "0.6,0.9", "--colour-map", "magma"};
  const auto stated = draw({{"look", look}}, {});
  EXPECT_FALSE(stated == plain);
  EXPECT_TRUE(draw(Json::object(), options) == stated);
  // Options come before the scene.
  const std::vector<std::string> plain_options{
      "--kind",  "exact",  "--colour-by", "isosurface", "--eye-dome",   "0.15",
      "--light", "-45,45", "--material",  "0.6,0.4",    "--colour-map", "viridis"};
  EXPECT_TRUE(draw({{"look", look}}, plain_options) == plain);
  EXPECT_TRUE(draw({{"look", {{"kind", "automatic"}}}}, {}) == plain);
  EXPECT_TRUE(draw({{"background", "#102030"}}, {"--background", "ffffff"}) == plain);

  // A slice hides the surfaces behind it, and shows the values of the first layer.
  const Json across = {{"slices", {{"along", {nullptr, 0.5, nullptr}}}}};
  const auto sliced = draw(across, {});
  EXPECT_FALSE(sliced == plain);
  // The same plane in the world: the volume is 24 voxels large, with spacing 1 from the origin.
  const Json oblique = {{"slices", {{"plane", {{"normal", {0, 2, 0}}, {"offset", 23}}}}}};
  EXPECT_TRUE(draw(oblique, {}) == sliced);
  Json dark = across;
  dark["slices"]["range"] = {1000, 2000};
  EXPECT_FALSE(draw(dark, {}) == sliced);
}

TEST_F(CliScene, OptionsForSettingsOfTheSceneAreRefused) {
  const Ended drawn = run({"render", scene, "-i", "5", "-o", folder / "x.png"});
  EXPECT_EQ(drawn.exit_code, 2);
  EXPECT_TRUE(drawn.err.find("--isovalue") != std::string::npos) << drawn.err;
  EXPECT_EQ(run({"render", folder / "stores/one.isosplat", "-o", folder / "x.png"}).exit_code, 2);
  const Ended step = run({"render", scene, "--step", "1", "-o", folder / "x.png"});
  EXPECT_EQ(step.exit_code, 1);
  EXPECT_TRUE(step.err.find("expected a time step from 0 to 0") != std::string::npos) << step.err;
}

/// Names come from strangers, so control characters in them must not reach the terminal.
TEST_F(CliScene, NamesAreWrittenWithoutControlCharacters) {
  Json json = Json::parse(document());
  json["name"] = "\x1b[2Jcleared";
  json["layers"][0]["name"] = "a\x1b]0;title\x07";
  write_file(scene, json.dump());
  const Ended info = run({"info", scene});
  EXPECT_EQ(info.exit_code, 0) << info.err;
  EXPECT_EQ(info.out.find('\x1b'), std::string::npos) << info.out;
  EXPECT_NE(info.out.find("cleared"), std::string::npos);
}

TEST_F(CliScene, FaultsAreNamed) {
  const auto expect_error = [&](const std::vector<std::string>& arguments,
                                const std::string& text) {
    const Ended ended = run(arguments);
    EXPECT_GT(ended.exit_code, 0) << ended.out;
    EXPECT_TRUE(ended.err.find(text) != std::string::npos) << ended.err;
  };
  const std::string out = folder / "x.isobundle", picture = folder / "x.png";
  write_file(scene, document("stores/none.isosplat"));
  expect_error({"bundle", scene, "-o", out}, "stores/none.isosplat");
  expect_error({"render", scene, "-o", picture}, "layer 0 (one)");
  expect_error({"verify", scene}, "stores/none.isosplat");
  write_file(scene, document("../elsewhere.isosplat"));
  expect_error({"bundle", scene, "-o", out}, "in the folder of the scene or below");
  write_file(scene, document("https://example.org/a.isosplat"));
  expect_error({"render", scene, "-o", picture}, "found a store at the address");
  write_file(scene, R"({"format":"isosplat-scene","version":1,"layers":[]})");
  expect_error({"info", scene}, "layers: expected a list of 1 to 4096");
  expect_error({"unbundle", scene, "-o", folder / "y"}, "layers: expected");
  EXPECT_FALSE(std::filesystem::exists(out));
  write_file(scene, document());
  ASSERT_EQ(bundle().exit_code, 0);
  expect_error({"bundle", bundle_file, "-o", out}, "expected a scene, found a bundle");
  expect_error({"bundle", scene, "-o", scene}, "not an input");
  write_file(folder / "other.txt", "important");
  expect_error({"bundle", scene, "-o", folder / "other.txt"}, "--force");
}

/// Wherever a bundle is damaged, opening it fails, or verify finds the damage. Nothing crashes or
/// hangs.
TEST_F(CliScene, DamagedBundlesAreErrors) {
  ASSERT_EQ(bundle().exit_code, 0);
  const std::string whole = read_file(bundle_file);
  const auto damaged = folder / "damaged.isobundle";
  std::mt19937 random(11);
  for (int i = 0; i < 24; ++i) {
    std::string bytes = whole;
    if (i % 4 == 0) {
      bytes.resize(random() % bytes.size());
    } else {
      // Half of the changes are in the header, which is the most sensitive part.
      const size_t at = i % 2 == 0 ? random() % 600 : random() % bytes.size();
      bytes[at] = static_cast<char>(bytes[at] ^ (1 + random() % 255));
    }
    write_file(damaged, bytes);
    const Ended verified = run({"verify", damaged});
    EXPECT_EQ(verified.exit_code, 1) << i << verified.out;
    EXPECT_FALSE(verified.err.empty());
    const Ended drawn =
        run({"render", damaged, "-o", folder / "d.png", "--size", "32x32", "--force"});
    EXPECT_TRUE(drawn.exit_code == 0 || drawn.exit_code == 1) << i << drawn.err;
  }
}

}  // namespace
}  // namespace isosplat
