// isosplat build of adaptive grids: a scene with a store for each refinement level.

#include <gtest/gtest.h>

#include <set>

#include "shared/core/scene/scene.h"
#include "shared/system/scene_file/scene_file.h"
#include "tests/native/cli_program.h"
#include "tests/native/field_files.h"
#include "tests/native/vtk_amr_files.h"
#include "tests/shared/blast_wave.h"

namespace isosplat {
namespace {

using adaptive_test::blast_wave;
using adaptive_test::Case;
using adaptive_test::Lattice;
using test::read_file;
using test::run;
using test::TempFolder;
using test::write_file;
using test::write_vtk_amr;

/// The cells of a lattice that are active in a store with this mapping, by brute force.
size_t active_cells(const Lattice& lattice, const ValueMapping& mapping, double isovalue) {
  const auto quantized = [&](double value) {
    return std::floor((value - mapping.offset) / mapping.scale + 0.5);
  };
  const double at = mapping.quantized_isovalue(isovalue);
  size_t count = 0;
  adaptive_test::for_each_index(lattice.voxels - Index3{1, 1, 1}, [&](Index3 i) {
    if (!lattice.has(lattice.low + i)) return;
    double low = 1e300, high = -1e300;
    adaptive_test::for_each_index({2, 2, 2}, [&](Index3 o) {
      const double value = quantized(lattice.values[adaptive_test::flat(i + o, lattice.voxels)]);
      low = std::min(low, value);
      high = std::max(high, value);
    });
    count += low <= at && at < high;
  });
  return count;
}

/// The number of vertices in the header of a PLY file.
size_t vertices(const std::string& path) {
  const std::string text = read_file(path);
  const size_t at = text.find("element vertex ");
  return at == text.npos ? 0 : std::stoul(text.substr(at + 15));
}

TEST(CliAdaptive, LevelsHaveOneMappingAndExactlyTheirActiveCells) {
  const TempFolder folder;
  const Case made = blast_wave(3);
  const std::string file = write_vtk_amr(folder, "blast", made);
  const std::string output = folder / "blast/";
  const auto ended = run({"build", file, "-o", output, "--no-thumbnail"});
  ASSERT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_NE(ended.out.find("3 refinement levels"), std::string::npos) << ended.out;
  EXPECT_NE(ended.err.find("weighted by the inverse"), std::string::npos) << ended.err;
  const auto scene = SceneFile::open(output + "scene.json");
  ASSERT_TRUE(scene) << scene.error().message;
  const auto& layers = scene->scene().layers;
  ASSERT_EQ(layers.size(), 3u);
  const auto grid = adaptive_test::make_grid(made);
  const auto lattices = adaptive_test::lattices_of(*grid);
  ValueMapping first;
  uint64_t bytes = 0, voxels = 0;
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(layers[i].part_of, "blast");
    ASSERT_EQ(layers[i].surfaces.size(), 1u);
    EXPECT_EQ(layers[i].surfaces[0].isovalue, layers[0].surfaces[0].isovalue);
    EXPECT_EQ(layers[i].surfaces[0].colour, layers[0].surfaces[0].colour);
    const auto store = scene->open_store(layers[i].stores[0]);
    ASSERT_TRUE(store) << store.error().message;
    const StoreInfo& info = (*store)->info();
    if (i == 0) first = info.mapping;
    EXPECT_EQ(info.mapping.offset, first.offset);
    EXPECT_EQ(info.mapping.scale, first.scale);
    EXPECT_EQ(info.mapping.has_missing, first.has_missing);
    ASSERT_EQ(info.grid.voxels, lattices[i].voxels);
    EXPECT_DOUBLE_EQ(info.grid.spacing.x, 0.0625 / (1 << i));
    EXPECT_DOUBLE_EQ(info.grid.origin.x, -1 + lattices[i].low.x * info.grid.spacing.x);
    bytes += std::filesystem::file_size(output + layers[i].stores[0]);
    for (const double value : lattices[i].values) voxels += std::isfinite(value);
    const std::string points = folder / "points.ply";
    for (const double isovalue : {1.3, 2.2, 2.9}) {
      const auto extracted = run({"extract", output + layers[i].stores[0], "--isovalue",
                                  fmt::format("{}", isovalue), "-o", points, "--force"});
      ASSERT_EQ(extracted.exit_code, 0) << extracted.err;
      EXPECT_EQ(vertices(points), active_cells(lattices[i], info.mapping, isovalue));
    }
  }
  // 16 bits for each node of a cell that is drawn.
  RecordProperty("store_per_mille_of_voxels", static_cast<int>(bytes * 1000 / (2 * voxels)));
  EXPECT_LE(static_cast<double>(bytes), 1.2 * 2 * static_cast<double>(voxels));
  EXPECT_EQ(run({"verify", output + "scene.json"}).exit_code, 0);
  EXPECT_EQ(run({"render", output + "scene.json", "-o", folder / "blast.png"}).exit_code, 0);
}

TEST(CliAdaptive, ABundleBesideTheFileIsTheDefault) {
  const TempFolder folder;
  Case made = adaptive_test::random_case(5, Centring::nodes);
  made.ratios = {3};
  made.cells = {4, 4, 4};
  made.patches = {{0, {{0, 0, 0}, {4, 4, 4}}, std::vector<double>(125)},
                  {1, {{3, 3, 3}, {9, 9, 9}}, std::vector<double>(343)}};
  for (auto& patch : made.patches) {
    for (size_t i = 0; i < patch.values.size(); ++i) patch.values[i] = static_cast<double>(i % 7);
  }
  const std::string file = write_vtk_amr(folder, "nodes", made);
  const auto ended = run({"build", file, "--no-thumbnail"});
  ASSERT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_TRUE(SceneFile::open(folder / "nodes.isobundle"));
  EXPECT_EQ(ended.err.find("weighted by the inverse"), std::string::npos) << ended.err;
  const auto to_store = run({"build", file, "-o", folder / "nodes.isosplat"});
  EXPECT_NE(to_store.exit_code, 0);
  EXPECT_NE(to_store.err.find("expected a bundle"), std::string::npos) << to_store.err;
}

/// One error for each malformed file, within the memory of a small program.
TEST(CliAdaptive, GridsAndRegularVolumesAreFields) {
  const TempFolder folder;
  const std::string file = write_vtk_amr(folder, "blast", blast_wave(3));
  const std::string output = folder / "blast/";
  // The values of the volume itself, and ten times x.
  const auto ended = run({"build", file, "-o", output, "--no-thumbnail", "--field", "same=" + file,
                          "--field", "x=" + test::write_ramp(folder, "x.nrrd", 11, 0.25, "-1.25")});
  ASSERT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_EQ(run({"verify", output + "scene.json"}).exit_code, 0);
  for (int level = 0; level < 3; ++level) {
    const std::string store = output + fmt::format("stores/level_{}.isosplat", level);
    const std::string ply = folder / "a.ply";
    for (const bool is_same : {true, false}) {
      const auto extracted = run({"extract", store, "-i", "1.3", "--mesh", "--open", "--field",
                                  is_same ? "same" : "x", "-o", ply, "--force"});
      ASSERT_EQ(extracted.exit_code, 0) << extracted.err;
      for (const auto& v : test::vertices_of(ply)) {
        ASSERT_NEAR(v[6], is_same ? 1.3 : 10 * v[0], 2e-3) << level;
      }
    }
  }
  const auto other = run({"build", file, "-o", output, "--no-thumbnail", "--force", "--field",
                          "t=" + std::string(folder / "none.vtu")});
  EXPECT_NE(other.exit_code, 0);
}

TEST(CliAdaptive, RefusesMalformedFiles) {
  const TempFolder folder;
  Case made;
  made.cells = {4, 4, 4};
  made.ratios = {2};
  made.patches = {{0, {{0, 0, 0}, {4, 4, 4}}, std::vector<double>(64, 1)},
                  {1, {{2, 2, 2}, {6, 6, 6}}, std::vector<double>(64, 2)}};
  made.patches[1].values[5] = 3;
  const std::string file = write_vtk_amr(folder, "a", made);
  const std::string text = read_file(file);
  const struct {
    std::string from, to, message;
  } cases[] = {
      {"amr_box=\"2 5", "amr_box=\"2 8", "inside of level 0"},
      {"amr_box=\"2 5", "amr_box=\"5 2", "expected an amr_box"},
      {"amr_box=\"2 5", "amr_box=\"-9000000000 5", "expected an amr_box"},
      {"amr_box=\"2 5", "amr_box=\"2", "expected an amr_box"},
      {"amr_box=\"2 5", "amr_box=\"1 4", "expected the position"},
      {"amr_box=\"2 5", "amr_box=\"2 4", "expected 3×4×4 cells"},
      {"amr_box=\"0 3 0 3 0 3\"", "amr_box=\"0 99999 0 99999 0 99999\"", "raise --memory"},
      {"a/a_1.vti", "a.vthb", "a.vthb"},
      {"a/a_1.vti", "a/missing.vti", "missing.vti"},
      {"version=\"1.1\"", "version=\"1.0\"", "expected version 1.1"},
      {"grid_description=\"XYZ\"", "grid_description=\"XY\"", "three dimensions"},
      {"origin=\"-1 -1 -1\"", "origin=\"-1\"", "an origin"},
      {"spacing=\"0.03125", "spacing=\"0.05", "spacing of level 1"},
      {"spacing=\"0.03125", "spacing=\"-0.03125", "positive"},
      {"level=\"1\"", "level=\"2\"", "a <Block> for each level"},
      {"</VTKFile>", "", "incomplete"},
  };
  for (const auto& each : cases) {
    std::string changed = text;
    const size_t at = changed.find(each.from);
    ASSERT_NE(at, changed.npos) << each.from;
    changed.replace(at, each.from.size(), each.to);
    write_file(file, changed);
    const auto ended = run({"build", file, "-o", folder / "b.isobundle", "--no-thumbnail"});
    EXPECT_NE(ended.exit_code, 0) << each.to;
    EXPECT_NE(ended.err.find(each.message), std::string::npos) << each.to << ": " << ended.err;
    EXPECT_FALSE(std::filesystem::exists(folder / "b.isobundle"));
  }
  const std::string patch = "<DataSet amr_box=\"0 1 0 1 0 1\" file=\"x\"/>";
  // Levels so fine that their cells cannot be counted.
  std::string deep = text.substr(0, text.find("    <Block level=\"1\""));
  double spacing = 0.0625;
  for (int level = 1; level < 20; ++level) {
    spacing /= 16;
    deep += fmt::format("<Block level=\"{0}\" spacing=\"{1} {1} {1}\">{2}</Block>", level, spacing,
                        level == 19 ? patch : "");
  }
  write_file(file, deep + "</vtkOverlappingAMR></VTKFile>");
  const auto too_deep = run({"build", file, "-o", folder / "b.isobundle"});
  EXPECT_NE(too_deep.exit_code, 0);
  EXPECT_NE(too_deep.err.find("expected fewer than 1048576 cells"), std::string::npos)
      << too_deep.err;
  // More patches than can be listed end the reading at once.
  std::string many = text.substr(0, text.find("      <DataSet"));
  for (size_t i = 0; i <= size_t{1} << 20; ++i) many += patch;
  write_file(file, many);
  const auto ended = run({"build", file, "-o", folder / "b.isobundle"});
  EXPECT_NE(ended.exit_code, 0);
  EXPECT_NE(ended.err.find("at most 1048576 patches"), std::string::npos) << ended.err;
}

TEST(CliAdaptive, VtkExampleHasFourLevels) {
  const auto volumes = test::volumes_folder();
  if (!volumes) GTEST_SKIP() << "needs volumes";
  const auto file = *volumes / "amr_hierarchical_box" / "HierarchicalBoxDataset.v1.1.vthb";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "needs " << file;
  const TempFolder folder;
  const auto ended =
      run({"build", file.string(), "-o", folder / "box.isobundle", "--channel", "4"});
  ASSERT_EQ(ended.exit_code, 0) << ended.err;
  const auto scene = SceneFile::open(folder / "box.isobundle");
  ASSERT_TRUE(scene);
  // Level 1 covers all cells of level 0.
  ASSERT_EQ(scene->scene().layers.size(), 3u);
  EXPECT_EQ(scene->scene().layers[0].name, "level 1");
}

}  // namespace
}  // namespace isosplat
