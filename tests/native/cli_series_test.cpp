// Builds of several stores on the command line: time steps in files, lists and one file; channels.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>

#include "native/scene/scene_text.h"
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

/// A cube of n³ floats: the distance from the centre, times `factor`.
std::string distances(double factor) {
  std::string voxels;
  for (int z = 0; z < kEdge; ++z) {
    for (int y = 0; y < kEdge; ++y) {
      for (int x = 0; x < kEdge; ++x) {
        const double half = (kEdge - 1) / 2.0;
        const auto value =
            static_cast<float>(factor * std::hypot(x - half, y - half + 0.1, z - half));
        voxels.append(reinterpret_cast<const char*>(&value), sizeof value);
      }
    }
  }
  return voxels;
}

class CliSeries : public ::testing::Test {
 protected:
  std::string write_step(const std::string& name, double factor) {
    return test::write_cube(folder, name, "float", kEdge, distances(factor));
  }

  static Scene scene_of(const std::filesystem::path& path) {
    const auto file = SceneFile::open(path);
    EXPECT_TRUE(file) << file.error().message;
    return file ? file->scene() : Scene{};
  }

  /// The mapping of each store of a scene, as text.
  static std::vector<std::string> mappings(const std::filesystem::path& path) {
    const auto file = SceneFile::open(path);
    std::vector<std::string> found;
    for (const std::string& store : store_paths(file->scene())) {
      const auto opened = file->open_store(store);
      EXPECT_TRUE(opened) << opened.error().message;
      const ValueMapping& mapping = (*opened)->info().mapping;
      found.push_back(fmt::format("{} {} {}", mapping.offset, mapping.scale, mapping.bits));
    }
    return found;
  }

  const TempFolder folder;
  const std::string output = folder / "run.isobundle";
};

TEST_F(CliSeries, FilesAreStepsInNaturalOrderWithOneMapping) {
  const std::vector<std::string> steps{write_step("step_100.nrrd", 3),
                                       write_step("step_20.nrrd", 2), write_step("step_3.nrrd", 1)};
  const Ended built =
      run({"build", steps[0], steps[1], steps[2], "-o", output, "--time-unit", "s"});
  ASSERT_EQ(built.exit_code, 0) << built.err;
  EXPECT_NE(built.out.find("1 layer, 3 time steps"), std::string::npos) << built.out;
  const Scene scene = scene_of(output);
  ASSERT_TRUE(scene.time);
  EXPECT_EQ(scene.time->values, (std::vector<double>{3, 20, 100}));
  EXPECT_EQ(scene.time->unit, "s");
  ASSERT_EQ(scene.layers.size(), 1u);
  EXPECT_EQ(scene.layers[0].stores.size(), 3u);
  EXPECT_EQ(scene.layers[0].surfaces.size(), 1u);
  const auto found = mappings(output);
  EXPECT_EQ(std::set(found.begin(), found.end()).size(), 1u) << found[0] << '\n' << found[1];
  // No other files remain.
  EXPECT_FALSE(std::filesystem::exists(folder / ".run.isobundle.parts"));
  EXPECT_EQ(run({"verify", output}).exit_code, 0);
}

TEST_F(CliSeries, AFolderHasTheSameStoresAndTakesFurtherSteps) {
  const std::vector<std::string> steps{write_step("a1.nrrd", 1), write_step("a2.nrrd", 2),
                                       write_step("a3.nrrd", 2)};
  const std::string scene = folder / "run/scene.json";
  ASSERT_EQ(run({"build", steps[0], steps[1], "-o", folder / "run/"}).exit_code, 0);
  EXPECT_EQ(scene_of(scene).layers[0].stores.size(), 2u);
  // The third step does not extend the range, so the others are not built again.
  const Ended more = run({"build", steps[0], steps[1], steps[2], "-o", folder / "run"});
  ASSERT_EQ(more.exit_code, 0) << more.err;
  EXPECT_NE(more.out.find("2 stores were complete before"), std::string::npos) << more.out;
  EXPECT_EQ(scene_of(scene).layers[0].stores.size(), 3u);
  // Build the same series into one file.
  ASSERT_EQ(run({"build", steps[0], steps[1], steps[2], "-o", output}).exit_code, 0);
  ASSERT_EQ(run({"unbundle", output, "-o", folder / "out"}).exit_code, 0);
  for (const char* name : {"volume_00000", "volume_00001", "volume_00002"}) {
    const std::string store = fmt::format("stores/{}.isosplat", name);
    EXPECT_EQ(read_file(folder / ("out/" + store)), read_file(folder / ("run/" + store))) << name;
  }
}

TEST_F(CliSeries, AnInterruptedBuildGoesOnWithTheSameBytes) {
  std::vector<std::string> call{"build"};
  for (int step = 0; step < 6; ++step)
    call.push_back(write_step(fmt::format("s{}.nrrd", step), step + 1));
  call.insert(call.end(), {"-o", output});
  ASSERT_EQ(run(call).exit_code, 0);
  const std::string whole = read_file(output);
  std::filesystem::remove(output);
  // The build is interrupted at several times.
  int interrupted = 0;
  for (const int microseconds : {5'000, 20'000, 40'000, 80'000, 150'000}) {
    const TempFolder logs;
    const pid_t child = test::start({.arguments = call}, logs / "out", logs / "err");
    usleep(static_cast<useconds_t>(microseconds));
    kill(child, SIGKILL);
    interrupted += test::wait_for(child, logs / "out", logs / "err").signal == SIGKILL;
  }
  EXPECT_GT(interrupted, 0);
  ASSERT_EQ(run(call).exit_code, 0);
  EXPECT_EQ(read_file(output), whole);
  EXPECT_FALSE(std::filesystem::exists(folder / ".run.isobundle.parts"));
}

TEST_F(CliSeries, AChangedInputIsBuiltAgain) {
  const std::string step = write_step("a1.nrrd", 1), other = write_step("a2.nrrd", 3);
  ASSERT_EQ(run({"build", step, other, "-o", folder / "run/"}).exit_code, 0);
  const auto before = read_file(folder / "run/stores/volume_00000.isosplat");
  write_step("a1.nrrd", 2);
  ASSERT_EQ(run({"build", step, other, "-o", folder / "run/"}).exit_code, 0);
  EXPECT_NE(read_file(folder / "run/stores/volume_00000.isosplat"), before);
}

TEST_F(CliSeries, AListStatesTimesAndPaths) {
  write_step("one.nrrd", 1);
  write_step("two words.nrrd", 2);
  const std::string list = folder / "steps.txt";
  write_file(list, "# time  path\n-1.5 one.nrrd\r\n\n  2e3\ttwo words.nrrd\n");
  const Ended built = run({"build", "--steps", list, "-o", output});
  ASSERT_EQ(built.exit_code, 0) << built.err;
  EXPECT_EQ(scene_of(output).time->values, (std::vector<double>{-1.5, 2000}));
  for (const auto& [text, expected] : std::vector<std::pair<std::string, std::string>>{
           {"", "found none"},
           {"1\n", "line 1: expected a time, a blank and a path"},
           {"x one.nrrd\n", "line 1: expected a time, a blank and a path"},
           {"1 one.nrrd\n1 one.nrrd\n", "line 2: expected a time above that of the step before"},
           {"nan one.nrrd\n", "line 1: expected a time"},
           {"1 lost.nrrd\n", "lost.nrrd"}}) {
    write_file(list, text);
    const Ended refused = run({"build", "--steps", list, "-o", output, "--force"});
    EXPECT_NE(refused.exit_code, 0) << text;
    EXPECT_NE(refused.err.find(expected), std::string::npos) << refused.err;
  }
}

TEST_F(CliSeries, AFileWithTimeStepsBecomesAScene) {
  const std::string path = folder / "moving.nrrd";
  write_file(path, fmt::format("NRRD0004\ntype: float\ndimension: 4\nsizes: {0} {0} {0} 3\n"
                               "kinds: space space space time\nspacings: 1 1 1 0.1\n"
                               "axismins: 0 0 0 0.2\nunits: \"mm\" \"mm\" \"mm\" \"ps\"\n"
                               "encoding: raw\nendian: little\n\n",
                               kEdge) +
                       distances(1) + distances(2) + distances(3));
  const Ended built = run({"build", path, "-o", output});
  ASSERT_EQ(built.exit_code, 0) << built.err;
  const Scene scene = scene_of(output);
  EXPECT_EQ(scene.layers[0].stores.size(), 3u);
  EXPECT_EQ(scene.time->values, (std::vector<double>{0.2, 0.3, 0.4}));
  EXPECT_EQ(scene.time->unit, "ps");
  const auto found = mappings(output);
  EXPECT_EQ(std::set(found.begin(), found.end()).size(), 1u);
  // One of the steps can still be built as a single store.
  const Ended one = run({"build", path, "--time-step", "1", "-o", folder / "one.isosplat"});
  EXPECT_EQ(one.exit_code, 0) << one.err;
}

/// A TIFF of 8-bit pages of `edge`² pixels; the first has the description.
std::string tiff_pages(const std::vector<std::string>& pages, uint32_t edge,
                       const std::string& description) {
  std::string file("II*\0", 4);
  const auto number = [&](uint32_t value, int bytes) {
    for (int i = 0; i < bytes; ++i) file.push_back(static_cast<char>(value >> 8 * i));
  };
  const auto size = [&] { return static_cast<uint32_t>(file.size()); };
  uint32_t link = 4;
  number(0, 4);
  for (size_t i = 0; i < pages.size(); ++i) {
    const uint32_t pixels = size();
    file += pages[i];
    const uint32_t text = size();
    if (i == 0) file += description + '\0';
    if (file.size() % 2 != 0) file.push_back('\0');
    const uint32_t directory = size();
    for (int b = 0; b < 4; ++b) file[link + b] = static_cast<char>(directory >> 8 * b);
    const auto entry = [&](uint32_t tag, uint32_t type, uint32_t count, uint32_t value) {
      number(tag, 2);
      number(type, 2);
      number(count, 4);
      number(value, 4);
    };
    number(i == 0 ? 9 : 8, 2);
    entry(256, 4, 1, edge);  // width
    entry(257, 4, 1, edge);  // height
    entry(258, 3, 1, 8);     // bits
    entry(259, 3, 1, 1);     // no compression
    entry(262, 3, 1, 1);     // black is zero
    if (i == 0) entry(270, 2, static_cast<uint32_t>(description.size()) + 1, text);
    entry(273, 4, 1, pixels);       // the strip
    entry(278, 4, 1, edge);         // its rows
    entry(279, 4, 1, edge * edge);  // its bytes
    link = size();
    number(0, 4);
  }
  return file;
}

TEST_F(CliSeries, ChannelsAreLayersWithTheirNamesAndColours) {
  constexpr uint32_t kPixels = 16;
  std::vector<std::string> pages;
  for (int page = 0; page < 6; ++page) {  // Z, then C
    std::string pixels;
    for (uint32_t i = 0; i < kPixels * kPixels; ++i) {
      pixels.push_back(static_cast<char>(i / kPixels * 9 + static_cast<uint32_t>(page) * 7));
    }
    pages.push_back(pixels);
  }
  const std::string path = folder / "cells.tif";
  write_file(path, tiff_pages(pages, kPixels,
                              "<?xml version=\"1.0\"?><OME><Image><Pixels DimensionOrder=\"XYZCT\" "
                              "SizeZ=\"3\" SizeC=\"2\" SizeT=\"1\"><Channel Name=\"DAPI\"/>"
                              "<Channel Name=\"GFP\" Color=\"16711935\"/></Pixels></Image></OME>"));
  const std::string cells = folder / "cells.isobundle";
  const Ended built = run({"build", path, "-o", cells});
  ASSERT_EQ(built.exit_code, 0) << built.err;
  const Scene scene = scene_of(cells);
  EXPECT_FALSE(scene.time);
  ASSERT_EQ(scene.layers.size(), 2u);
  EXPECT_EQ(scene.layers[0].name, "DAPI");
  EXPECT_EQ(scene.layers[1].name, "GFP");
  EXPECT_NE(scene.layers[0].stores, scene.layers[1].stores);
  ASSERT_EQ(scene.layers[1].surfaces.size(), 1u);
  EXPECT_NE(scene.layers[0].surfaces[0].colour, scene.layers[1].surfaces[0].colour);
  EXPECT_EQ(scene.layers[1].surfaces[0].colour, (std::array<float, 3>{0, 1, 0}));
  const Ended one = run({"build", path, "--channel", "1", "-o", folder / "gfp.isosplat"});
  ASSERT_EQ(one.exit_code, 0) << one.err;
  const Ended neither = run({"build", path, "-o", folder / "none.isosplat"});
  EXPECT_NE(neither.err.find("--channel 0 to --channel 1"), std::string::npos) << neither.err;
}

TEST_F(CliSeries, OutputsAndInputsAreKept) {
  const std::string step = write_step("a1.nrrd", 1), other = write_step("a2.nrrd", 3);
  const Ended several = run({"build", step, other, "-o", folder / "one.isosplat"});
  EXPECT_EQ(several.exit_code, 2);
  EXPECT_NE(several.err.find("-o NAME.isobundle"), std::string::npos) << several.err;
  EXPECT_EQ(run({"build", "-o", output}).exit_code, 2);
  write_file(output, "no bundle");
  EXPECT_NE(run({"build", step, other, "-o", output}).exit_code, 0);
  EXPECT_EQ(read_file(output), "no bundle");
  std::filesystem::create_directories(folder / "mine");
  write_file(folder / "mine/scene.json", "{}");
  EXPECT_NE(run({"build", step, other, "-o", folder / "mine"}).exit_code, 0);
  EXPECT_EQ(read_file(folder / "mine/scene.json"), "{}");
}

TEST(SceneText, IsReadAsTheSameScene) {
  Scene scene;
  scene.name = "Head \xC3\xA9";
  scene.time = SceneTime{{0, 0.1, 3}, "s"};
  SceneLayer& layer = scene.layers.emplace_back();
  layer.name = "one";
  layer.group = "g";
  layer.stores = {"a", "b", "c"};
  layer.visible = false;
  layer.surfaces = {{1.5, {{1, 0, 0.2f}}, 0.5f}, {-1e30, {}, 1}};
  layer.transform = AffineTransform{1, 0, 0, 2, 0, 1, 0, 3, 0, 0, 1, 4, 0, 0, 0, 1};
  scene.layers.emplace_back().stores = {"only"};
  scene.camera = SceneCamera{{1, 2, 3}, 4, 5, 6, 7, 8, true};
  scene.clip = {{0, 0.5, 0}, {1, 1, 1}, {{{0, 0, 1}, 2}}, true};
  scene.background = {{1, 1, 1, 0}};
  const std::string text = scene_text(scene);
  const auto read = parse_scene(text);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(scene_text(*read), text);
  EXPECT_EQ(read->layers[0].stores, scene.layers[0].stores);
  EXPECT_EQ(read->time->values, scene.time->values);
  EXPECT_EQ(read->layers[0].surfaces[1].isovalue, -1e30);
  EXPECT_EQ(read->camera->field_of_view, 8);
  EXPECT_EQ(read->clip.planes.size(), 1u);
}

/// The range of the only field of each store of a scene.
std::vector<std::pair<double, double>> field_ranges(const std::filesystem::path& path) {
  const auto file = SceneFile::open(path);
  std::vector<std::pair<double, double>> ranges;
  for (const std::string& store : store_paths(file->scene())) {
    const auto opened = file->open_store(store);
    EXPECT_TRUE(opened) << opened.error().message;
    const auto& fields = (*opened)->info().fields;
    EXPECT_EQ(fields.size(), 1u);
    if (fields.size() != 1) return {};
    const FieldInfo& field = fields[0].info;
    ranges.emplace_back(field.mapping.value(field.range.min), field.mapping.value(field.range.max));
  }
  return ranges;
}

TEST_F(CliSeries, FieldsHaveAVolumeForEachStepOrOneForAll) {
  const std::vector<std::string> steps{write_step("step_10.nrrd", 1), write_step("step_9.nrrd", 2)};
  const std::string constant = write_step("constant.nrrd", 5);
  write_step("t_9.nrrd", 20);
  write_step("t_10.nrrd", 10);
  const auto build = [&](const std::string& field) {
    return run({"build", steps[0], steps[1], "-o", output, "--no-thumbnail", "--force", "--field",
                "t=" + field});
  };
  const double most = std::hypot(9.5, 9.6, 9.5);
  const auto expect_greatest = [&](double first, double second) {
    const auto ranges = field_ranges(output);
    ASSERT_EQ(ranges.size(), 2u);
    EXPECT_NEAR(ranges[0].second, first * most, 0.1 * most);
    EXPECT_NEAR(ranges[1].second, second * most, 0.1 * most);
  };
  Ended built = build(folder / "t_*.nrrd");
  ASSERT_EQ(built.exit_code, 0) << built.err;
  expect_greatest(20, 10);
  built = build(constant);
  ASSERT_EQ(built.exit_code, 0) << built.err;
  expect_greatest(5, 5);
  write_file(folder / "list.txt", "9 t_10.nrrd\n10 t_9.nrrd\n");
  built = build(folder / "list.txt");
  ASSERT_EQ(built.exit_code, 0) << built.err;
  expect_greatest(10, 20);
  EXPECT_EQ(run({"verify", output}).exit_code, 0);

  built = build("@gradient");
  ASSERT_EQ(built.exit_code, 0) << built.err;
  EXPECT_NEAR(field_ranges(output)[0].second, 2, 0.1);
  EXPECT_NEAR(field_ranges(output)[1].second, 1, 0.1);

  write_file(folder / "list.txt", "9 t_10.nrrd\n11 t_9.nrrd\n");
  EXPECT_NE(build(folder / "list.txt").err.find("found other times"), std::string::npos);
  EXPECT_NE(build(folder / "none_*.nrrd").err.find("found none"), std::string::npos);
  write_step("t_11.nrrd", 10);
  EXPECT_NE(
      build(folder / "t_*.nrrd").err.find("each of the 2 time steps, or one for all, found 3"),
      std::string::npos);
}

TEST_F(CliSeries, FieldsOfAFileWithTimeStepsAreThoseOfTheSteps) {
  const auto write = [&](const std::string& name, double a, double b) {
    const std::string path = folder / name;
    write_file(path, fmt::format("NRRD0004\ntype: float\ndimension: 4\nsizes: {0} {0} {0} 2\n"
                                 "kinds: domain domain domain time\nencoding: raw\n"
                                 "endian: little\n\n",
                                 kEdge) +
                         distances(a) + distances(b));
    return path;
  };
  const std::string density = write("density.nrrd", 1, 2), field = write("field.nrrd", 20, 10);
  const Ended built =
      run({"build", density, "-o", output, "--no-thumbnail", "--field", "t=" + field});
  ASSERT_EQ(built.exit_code, 0) << built.err;
  const auto ranges = field_ranges(output);
  ASSERT_EQ(ranges.size(), 2u);
  EXPECT_NEAR(ranges[0].second, 2 * ranges[1].second, 0.1);
}

TEST_F(CliSeries, AChangedFieldIsBuiltAgain) {
  const std::string step = write_step("s_1.nrrd", 1), other = write_step("s_2.nrrd", 2);
  const std::string target = folder / "run/", field = write_step("t.nrrd", 3);
  std::filesystem::create_directory(target);
  const auto expect_greatest = [&](const std::string& of, bool is_kept, double value) {
    const Ended built =
        run({"build", step, other, "-o", target, "--no-thumbnail", "--field", "t=" + of});
    ASSERT_EQ(built.exit_code, 0) << built.err;
    EXPECT_EQ(built.out.find("complete before") != std::string::npos, is_kept) << built.out;
    const auto ranges = field_ranges(target + "scene.json");
    ASSERT_EQ(ranges.size(), 2u);
    EXPECT_NEAR(ranges[0].second, value, 0.1 * std::abs(value));
  };
  const double most = std::hypot(9.5, 9.6, 9.5);
  expect_greatest(field, false, 3 * most);
  expect_greatest(field, true, 3 * most);
  write_step("t.nrrd", 4);
  std::filesystem::last_write_time(field, std::filesystem::file_time_type::clock::now());
  expect_greatest(field, false, 4 * most);
  expect_greatest(other, false, 2 * most);
  expect_greatest("@gradient", false, 1);
  expect_greatest("@curvature", false, -0.068);
}

}  // namespace
}  // namespace isosplat
