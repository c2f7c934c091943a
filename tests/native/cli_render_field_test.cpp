// isosplat render --field.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "native/headless/image.h"
#include "tests/native/cli_program.h"

namespace isosplat {
namespace {

using test::Ended;
using test::run;
using test::TempFolder;

class CliRenderField : public ::testing::Test {
 protected:
  void SetUp() override {
    const std::string volume = test::write_ball(folder, 24);
    const std::string x = test::write_cube(
        folder, "t.nrrd", "int16", 24, test::cube<int16_t>(24, [](int i) { return i % 24 - 300; }));
    const Ended built = run({"build", volume, "-o", store, "--no-thumbnail", "--field", "x=" + x,
                             "--field", "same=" + volume});
    ASSERT_EQ(built.exit_code, 0) << built.err;
    const Ended plain = run({"build", volume, "-o", without, "--no-thumbnail"});
    ASSERT_EQ(plain.exit_code, 0) << plain.err;
  }

  Ended render(const std::string& file, std::vector<std::string> options,
               const char* of = nullptr) {
    options.insert(options.begin(), {"render", of ? of : store, "-i", "127.5", "--size", "96x96",
                                     "--force", "-o", folder / file});
    return run(options);
  }

  /// The picture that these options make.
  Image picture(std::vector<std::string> options) {
    const Ended ended = render("picture.png", std::move(options));
    EXPECT_EQ(ended.exit_code, 0) << ended.err;
    const auto image = read_png(folder / "picture.png");
    EXPECT_TRUE(image) << image.error().message;
    return image.value();
  }

  /// The largest difference of two pictures, of 255.
  static int difference(const Image& a, const Image& b) {
    int most = a.rgba.size() == b.rgba.size() ? 0 : 255;
    for (size_t i = 0; i < std::min(a.rgba.size(), b.rgba.size()); ++i) {
      most = std::max(most, std::abs(int(a.rgba[i]) - int(b.rgba[i])));
    }
    return most;
  }

  const TempFolder folder;
  const std::string store = folder / "x.isosplat", without = folder / "plain.isosplat";
};

TEST_F(CliRenderField, ShowsTheValuesOnTheSurface) {
  // A field with the volume's own values has the isovalue everywhere on the surface.
  for (const char* range : {"100,200", "120,130", "0,1"}) {
    for (const char* kind : {"quad", "ellipse", "exact"}) {
      const std::vector<std::string> look{"--kind", kind, "--colour-map", "magma"};
      std::vector<std::string> by_field{"--field", "same", "--field-range", range};
      std::vector<std::string> by_isovalue{"--colour-by", "isovalue", "--range", range};
      by_field.insert(by_field.end(), look.begin(), look.end());
      by_isovalue.insert(by_isovalue.end(), look.begin(), look.end());
      const Image image = picture(by_field);
      // Squares show the value at a sample near the surface.
      const int tolerance = std::string(kind) == "quad" ? 50 : 4;
      EXPECT_LE(difference(image, picture(by_isovalue)), tolerance) << range << ' ' << kind;
      EXPECT_FALSE(image.is_uniform());
    }
  }
  EXPECT_GT(difference(picture({"--field", "x"}), picture({"--field", "same"})), 50);
  EXPECT_GT(difference(picture({"--field", "x"}), picture({"--field", "x", "--field-steps", "3"})),
            30);
}

TEST_F(CliRenderField, DrawsContourLines) {
  const Image plain = picture({"--field", "x", "--field-range", "-300,-277"});
  const Image lined = picture({"--field", "x", "--field-range", "-300,-277", "--field-lines", "4"});
  // On the sphere of this size x has 17 values: four lines, each some 50 px long.
  int changed = 0;
  for (size_t i = 0; i < plain.rgba.size(); i += 4) {
    changed += std::abs(int(plain.rgba[i + 1]) - int(lined.rgba[i + 1])) > 40;
  }
  EXPECT_GT(changed, 60);
  EXPECT_LT(changed, 800);
  // Nothing remains of lines that are too dense.
  const Image dense =
      picture({"--field", "x", "--field-range", "-300,-277", "--field-lines", "1e-300"});
  EXPECT_LE(difference(dense, plain), 2);
}

TEST_F(CliRenderField, PrintsTheRangeOfItsColours) {
  const Ended ended = render("range.png", {"--field", "x"});
  ASSERT_EQ(ended.exit_code, 0) << ended.err;
  double low = 0, high = 0;
  const size_t at = ended.out.find("field x: colours from ");
  ASSERT_NE(at, std::string::npos) << ended.out;
  ASSERT_EQ(std::sscanf(ended.out.c_str() + at, "field x: colours from %lf to %lf", &low, &high),
            2);
  // The surface is in the middle of the volume, whose values are −300 to −277.
  EXPECT_GT(low, -300);
  EXPECT_LT(low, -289);
  EXPECT_LT(high, -277);
  EXPECT_GT(high, -288);
  EXPECT_NEAR(low + high, -577, 2);
  const Ended symmetric =
      render("range.png", {"--field", "x", "--field-scale", "symmetric", "--field-range", "-2,1"});
  EXPECT_NE(symmetric.out.find("colours from -2 to 2"), std::string::npos) << symmetric.out;
}

TEST_F(CliRenderField, RefusesWhatItCannotShow) {
  const auto expect_refused = [&](const std::vector<std::string>& options,
                                  const std::string& message, const char* of = nullptr) {
    const Ended refused = render("none.png", options, of);
    EXPECT_NE(refused.exit_code, 0);
    EXPECT_NE(refused.err.find(message), std::string::npos) << refused.err;
    EXPECT_FALSE(std::filesystem::exists(folder / "none.png"));
  };
  expect_refused({"--field", "y"}, "field 'y': expected a field of the store, which has x, same");
  expect_refused({"--field", "x"}, "expected a store with fields", without.c_str());
  expect_refused({"--field-range", "1,2"}, "--field");
  for (const char* interval : {"0", "-2", "nan", "inf", "5 K"}) {
    expect_refused({"--field", "x", "--field-lines", interval}, "expected a number above 0");
  }
  expect_refused({"--field-lines", "2"}, "--field");
  expect_refused({"--field", "x", "--colour-by", "depth"}, "--colour-by");
  expect_refused({"--field", "x", "--range", "1,2"},
                 "--field excludes --range: --field-range states");
  expect_refused({"--field", "x", "--field-scale", "logarithmic", "--field-range", "-1,2"},
                 "expected values above 0");
}

TEST_F(CliRenderField, OfScenesIsThatOfAVisibleLayer) {
  const auto scene = [&](bool is_first_visible, const char* isovalue) {
    test::write_file(folder / "scene.json",
                     fmt::format(R"({{"format":"isosplat-scene","version":1,"layers":[
  {{"name":"a","visible":{},"store":"x.isosplat","surfaces":[{{"isovalue":{}}}]}},
  {{"name":"b","store":"plain.isosplat","surfaces":[{{"isovalue":127.5}}]}}]}})",
                                 is_first_visible, isovalue));
  };
  const auto render_scene = [&](const char* field) {
    std::filesystem::remove(folder / "s.png");
    return run({"render", folder / "scene.json", "--size", "96x96", "-o", folder / "s.png",
                "--field", field});
  };
  scene(true, "127.5");
  const Ended shown = render_scene("x");
  EXPECT_EQ(shown.exit_code, 0) << shown.err;
  EXPECT_NE(shown.out.find("field x: colours from -"), std::string::npos) << shown.out;
  const Ended typo = render_scene("y");
  EXPECT_NE(typo.exit_code, 0);
  EXPECT_NE(typo.err.find("field 'y': expected a field of a visible layer, which have x, same"),
            std::string::npos)
      << typo.err;
  EXPECT_EQ(typo.out.find("colours from"), std::string::npos) << typo.out;
  EXPECT_FALSE(std::filesystem::exists(folder / "s.png"));
  // A surface without values: the range of the whole field.
  scene(true, "9999");
  const Ended none = render_scene("x");
  EXPECT_EQ(none.exit_code, 0) << none.err;
  EXPECT_NE(none.out.find("field x: colours from -300 to -277"), std::string::npos) << none.out;
  scene(false, "127.5");
  const Ended hidden = render_scene("x");
  EXPECT_NE(hidden.exit_code, 0);
  EXPECT_NE(hidden.err.find("expected a visible layer with fields, found none"), std::string::npos)
      << hidden.err;
}

}  // namespace
}  // namespace isosplat
