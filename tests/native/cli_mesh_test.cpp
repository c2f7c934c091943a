// isosplat build of unstructured grids: a scene of the adaptive grid that they become.

#include <gtest/gtest.h>

#include "shared/core/scene/scene.h"
#include "shared/system/scene_file/scene_file.h"
#include "tests/native/cli_program.h"
#include "tests/native/field_files.h"
#include "tests/native/vtk_mesh_files.h"

namespace isosplat {
namespace {

using mesh_test::add_block;
using mesh_test::Division;
using test::run;
using test::TempFolder;
using test::vtu_text;
using test::write_file;

constexpr Box kUnit{{0, 0, 0}, {1, 1, 1}};

UnstructuredMesh distance_mesh(Division division) {
  UnstructuredMesh mesh;
  add_block(mesh, kUnit, {6, 6, 6}, division);
  mesh_test::set_values(mesh, [](Vec3d p) { return length(p - Vec3d{0.1, 0.1, 0.1}); });
  return mesh;
}

TEST(CliMesh, LevelsAreOneLayerAndTheErrorIsReported) {
  const TempFolder folder;
  const std::string file = folder / "mixed.vtu", output = folder / "mixed/";
  write_file(file, vtu_text(distance_mesh(Division::mixed)));
  const auto ended = run({"build", file, "-o", output, "--no-thumbnail", "--dataset", "density",
                          "--max-error", "0.01"});
  ASSERT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_NE(ended.err.find("cells of a mesh became"), std::string::npos) << ended.err;
  EXPECT_NE(ended.err.find("(limit: 0.01)"), std::string::npos) << ended.err;
  EXPECT_EQ(ended.err.find("have no values"), std::string::npos) << ended.err;
  const auto scene = SceneFile::open(output + "scene.json");
  ASSERT_TRUE(scene) << scene.error().message;
  ASSERT_GE(scene->scene().layers.size(), 2u);
  for (const SceneLayer& layer : scene->scene().layers) {
    EXPECT_EQ(layer.part_of, "mixed");
    const auto store = scene->open_store(layer.stores[0]);
    ASSERT_TRUE(store);
    // The error of the grid is not that of the stores.
    EXPECT_LT((*store)->info().mapping.max_error, 1e-4);
  }
  EXPECT_EQ(run({"verify", output + "scene.json"}).exit_code, 0);
}

TEST(CliMesh, TheMemoryIsBelowItsLimit) {
  const TempFolder folder;
  {
    UnstructuredMesh mesh;
    add_block(mesh, kUnit, {40, 40, 40}, Division::tetrahedra);
    mesh_test::set_values(mesh, [](Vec3d p) { return p.x + std::sin(9 * p.y); });
    write_file(folder / "a.vtu", vtu_text(mesh));
  }
  const auto build = [&](const char* memory) {
    return run({"build", folder / "a.vtu", "--no-thumbnail", "--force", "--threads", "1",
                "--memory", memory});
  };
  // The program itself, with the pages of its file.
  constexpr uint64_t kProgram = uint64_t{24} << 20;
  const auto ended = build("80M");
  ASSERT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_NE(ended.err.find("384,000 cells of a mesh"), std::string::npos) << ended.err;
  EXPECT_LT(ended.peak_bytes, (uint64_t{80} << 20) + kProgram);
  const auto refused = build("20M");
  EXPECT_NE(refused.exit_code, 0);
  EXPECT_NE(refused.err.find("raise --memory"), std::string::npos) << refused.err;
  EXPECT_LT(refused.peak_bytes, (uint64_t{20} << 20) + kProgram);
}

TEST(CliMesh, ABundleBesideTheFileIsTheDefault) {
  const TempFolder folder;
  write_file(folder / "a.vtu", vtu_text(distance_mesh(Division::hexahedra)));
  EXPECT_EQ(run({"build", folder / "a.vtu", "--no-thumbnail"}).exit_code, 0);
  EXPECT_TRUE(SceneFile::open(folder / "a.isobundle"));
}

TEST(CliMesh, PiecesAreJoined) {
  const TempFolder folder;
  for (int i = 0; i < 2; ++i) {
    UnstructuredMesh mesh;
    add_block(mesh, {{1.0 * i, 0, 0}, {1.0 + i, 1, 1}}, {3, 3, 3}, Division::hexahedra);
    mesh_test::set_values(mesh, [](Vec3d p) { return p.x; });
    write_file(folder / fmt::format("p{}.vtu", i), vtu_text(mesh));
  }
  write_file(folder / "all.pvtu",
             "<VTKFile type=\"PUnstructuredGrid\" version=\"1.0\"><PUnstructuredGrid>"
             "<PPointData><PDataArray type=\"Float64\" Name=\"density\"/></PPointData>"
             "<Piece Source=\"p0.vtu\"/><Piece Source=\"p1.vtu\"/></PUnstructuredGrid></VTKFile>");
  const auto ended = run({"build", folder / "all.pvtu", "-o", folder / "all/", "--no-thumbnail"});
  ASSERT_EQ(ended.exit_code, 0) << ended.err;
  const auto scene = SceneFile::open(folder / "all/scene.json");
  ASSERT_TRUE(scene);
  ASSERT_EQ(scene->scene().layers.size(), 1u);
  const auto store = scene->open_store(scene->scene().layers[0].stores[0]);
  ASSERT_TRUE(store);
  EXPECT_EQ((*store)->info().grid.voxels, (Index3{7, 4, 4}));
  EXPECT_FALSE((*store)->info().mapping.has_missing);
}

TEST(CliMesh, EmptyPiecesAreAllowed) {
  const TempFolder folder;
  const std::string empty = vtu_text({});
  ASSERT_NE(empty.find("NumberOfPoints=\"0\" NumberOfCells=\"0\""), std::string::npos);
  write_file(folder / "p0.vtu", empty);
  write_file(folder / "p1.vtu", vtu_text(distance_mesh(Division::hexahedra)));
  const auto list = [](const std::string& pieces) {
    return "<VTKFile type=\"PUnstructuredGrid\" version=\"1.0\"><PUnstructuredGrid>" + pieces +
           "</PUnstructuredGrid></VTKFile>";
  };
  write_file(folder / "all.pvtu", list("<Piece Source=\"p0.vtu\"/><Piece Source=\"p1.vtu\"/>"));
  const auto ended = run({"build", folder / "all.pvtu", "--no-thumbnail"});
  ASSERT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_NE(ended.err.find("216 cells of a mesh became"), std::string::npos) << ended.err;
  write_file(folder / "none.pvtu", list("<Piece Source=\"p0.vtu\"/>"));
  for (const char* file : {"none.pvtu", "p0.vtu"}) {
    const auto none = run({"build", folder / file, "--no-thumbnail"});
    EXPECT_NE(none.exit_code, 0);
    EXPECT_NE(none.err.find("expected points and cells, found none"), std::string::npos)
        << none.err;
  }
}

/// Ghost flags of the first four cells of a mesh in a row.
TEST(CliMesh, RepeatedAndHiddenCellsAreLeftOut) {
  UnstructuredMesh mesh;
  add_block(mesh, {{0, 0, 0}, {8, 1, 1}}, {8, 1, 1}, Division::hexahedra);
  mesh_test::set_values(mesh, [](Vec3d p) { return p.x; });
  const std::string text = vtu_text(mesh);
  const struct {
    const char *name, *flags;
    int left_out;
  } cases[] = {
      {"vtkGhostType", "1 8 32 33 0 0 0 0", 4},  // duplicate, refined, hidden
      {"vtkGhostType", "16 2 4 22 0 0 0 0", 0},  // exterior, connectivity
      {"vtkGhostType", "17 2 0 0 0 0 0 0", 1},  {"vtkGhostLevels", "1 2 0 0 0 0 0 0", 2},
      {"vtkGhostLevels", "0 0 0 0 0 0 0 0", 0},
  };
  for (const auto& each : cases) {
    const TempFolder folder;
    std::string changed = text;
    const size_t at = changed.find("</CellData>");
    ASSERT_NE(at, changed.npos);
    changed.insert(at, fmt::format("<DataArray type=\"UInt8\" Name=\"{}\" format=\"ascii\">{}"
                                   "</DataArray>",
                                   each.name, each.flags));
    write_file(folder / "a.vtu", changed);
    const auto ended = run({"build", folder / "a.vtu", "--no-thumbnail"});
    ASSERT_EQ(ended.exit_code, 0) << ended.err;
    const std::string became = fmt::format("{} cells of a mesh became", 8 - each.left_out);
    EXPECT_NE(ended.err.find(became), std::string::npos) << each.flags << ended.err;
    const std::string note = fmt::format("{} cells are marked as repeated", each.left_out);
    EXPECT_EQ(ended.err.find(note) != std::string::npos, each.left_out > 0) << ended.err;
  }
}

TEST(CliMesh, ValuesOfCellsAreAveragedWithANote) {
  const TempFolder folder;
  write_file(folder / "a.vtu", vtu_text(distance_mesh(Division::tetrahedra)));
  const auto ended = run({"build", folder / "a.vtu", "-o", folder / "b/", "--no-thumbnail",
                          "--dataset", "number", "--max-error", "100"});
  ASSERT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_NE(ended.err.find("weighted by their volumes"), std::string::npos) << ended.err;
}

/// A cell without a value is a hole, although its points have values of the cells around it.
TEST(CliMesh, CellsWithoutAValueAreHoles) {
  UnstructuredMesh mesh;
  add_block(mesh, kUnit, {3, 3, 3}, Division::hexahedra);
  mesh_test::set_values(mesh, [](Vec3d p) { return p.x; });
  const std::string text = vtu_text(mesh);
  for (const bool is_nan : {false, true}) {
    const TempFolder folder;
    std::string changed = text;
    const size_t at = changed.find("12\n13\n14\n");
    ASSERT_NE(at, changed.npos);
    if (is_nan) changed.replace(at + 3, 2, "nan").replace(changed.find("Int32"), 5, "Float64");
    write_file(folder / "a.vtu", changed);
    std::vector<std::string> call{"build",  folder / "a.vtu", "-o", folder / "b/", "--dataset",
                                  "number", "--no-thumbnail"};
    if (!is_nan) call.insert(call.end(), {"--missing-value", "13"});
    const auto ended = run(call);
    ASSERT_EQ(ended.exit_code, 0) << ended.err;
    EXPECT_NE(ended.err.find("1 cells have no value: they are left out"), std::string::npos)
        << ended.err;
    EXPECT_NE(ended.err.find("26 cells of a mesh became"), std::string::npos) << ended.err;
    const auto scene = SceneFile::open(folder / "b/scene.json");
    ASSERT_TRUE(scene);
    const auto store = scene->open_store(scene->scene().layers[0].stores[0]);
    ASSERT_TRUE(store);
    EXPECT_TRUE((*store)->info().mapping.has_missing);
  }
}

/// The vertices of an isosurface, with the values of the field "t".
std::vector<std::array<float, 7>> surface_with_field(const TempFolder& folder,
                                                     const std::string& scene) {
  std::vector<std::array<float, 7>> all;
  const auto file = SceneFile::open(scene + "scene.json");
  EXPECT_TRUE(file) << file.error().message;
  for (const SceneLayer& layer : file->scene().layers) {
    const std::string ply = folder / "part.ply";
    const auto ended = run({"extract", scene + layer.stores[0], "-i", "0.8", "--mesh", "--open",
                            "--field", "t", "-o", ply, "--force"});
    EXPECT_EQ(ended.exit_code, 0) << ended.err;
    const auto vertices = test::vertices_of(ply);
    all.insert(all.end(), vertices.begin(), vertices.end());
  }
  EXPECT_GT(all.size(), 300u);
  return all;
}

TEST(CliMesh, OtherArraysAndMeshesAreFields) {
  const TempFolder folder;
  const std::string file = folder / "mixed.vtu", other = folder / "other.vtu";
  UnstructuredMesh mesh = distance_mesh(Division::mixed);
  write_file(file, vtu_text(mesh));
  mesh_test::set_values(mesh, [](Vec3d p) { return 3 * p.x - p.y + 2 * p.z; });
  write_file(other, vtu_text(mesh));
  const std::string output = folder / "mixed/";
  const auto build = [&](const std::string& field) {
    return run({"build", file, "-o", output, "--no-thumbnail", "--force", "--dataset", "density",
                "--field", "t=" + field});
  };
  auto ended = build(other + "#density");
  ASSERT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_EQ(run({"verify", output + "scene.json"}).exit_code, 0);
  // Linear functions are exact, also on the border of the mesh.
  for (const auto& v : surface_with_field(folder, output)) {
    ASSERT_NEAR(v[6], 3 * v[0] - v[1] + 2 * v[2], 2e-3);
  }
  ended = build(file + "#density");
  ASSERT_EQ(ended.exit_code, 0) << ended.err;
  for (const auto& v : surface_with_field(folder, output)) ASSERT_NEAR(v[6], 0.8, 1e-3);
  ended = build(test::write_ramp(folder, "ramp.nrrd", 13, 0.1, "-0.1"));
  ASSERT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_NE(ended.err.find("field 't': resampled from"), std::string::npos) << ended.err;
  for (const auto& v : surface_with_field(folder, output)) ASSERT_NEAR(v[6], 10 * v[0], 2e-3);

  ended = build(file + "#none");
  EXPECT_NE(ended.exit_code, 0);
  EXPECT_NE(ended.err.find("none"), std::string::npos) << ended.err;
  const auto both =
      run({"build", folder / "ball.nrrd", "-o", folder / "b.isosplat", "--field", "t=" + file});
  EXPECT_NE(both.exit_code, 0);
}

TEST(CliMesh, PointsOfCellsAreExtractedWithoutAStore) {
  const TempFolder folder;
  const std::string file = folder / "mixed.vtu", ply = folder / "a.ply";
  UnstructuredMesh mesh;
  add_block(mesh, kUnit, {6, 6, 6}, Division::mixed);
  mesh_test::set_values(mesh, [](Vec3d p) { return 3 * p.x - p.y + 2 * p.z; });
  write_file(file, vtu_text(mesh));
  auto ended =
      run({"extract", file, "--dataset", "density", "-i", "1.1", "--field", "number", "-o", ply});
  ASSERT_EQ(ended.exit_code, 0) << ended.err;
  const std::string text = test::read_file(ply);
  EXPECT_NE(text.find("property float number\nproperty float size\n"), std::string::npos) << text;
  size_t active = 0;
  for (size_t cell = 0; cell < mesh.cells(); ++cell) {
    double least = 1e300, most = -1e300;
    for (const uint32_t corner : mesh.corners_of(cell)) {
      least = std::min(least, mesh.values[corner]);
      most = std::max(most, mesh.values[corner]);
    }
    active += least <= 1.1 && 1.1 < most;
  }
  EXPECT_NE(ended.out.find(fmt::format("{} points with normals", active)), std::string::npos)
      << ended.out;
  const size_t begin = text.find("end_header\n") + 11;
  for (size_t i = 0; i < active; ++i) {
    std::array<float, 8> v;  // position, normal, number, size
    std::memcpy(v.data(), &text.at(begin + i * sizeof v), sizeof v);
    ASSERT_NEAR(3 * v[0] - v[1] + 2 * v[2], 1.1, 1e-5);
    ASSERT_NEAR((-3 * v[3] + v[4] - 2 * v[5]) / std::sqrt(14.0), 1, 1e-5);
    ASSERT_TRUE(v[6] >= 0 && v[6] < static_cast<float>(mesh.cells()));
    ASSERT_TRUE(v[7] > 0.05f && v[7] < 0.4f) << v[7];
  }
  ended = run({"extract", file, "--dataset", "density", "-i", "99", "-o", ply, "--force"});
  EXPECT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_NE(ended.err.find("no cell has values on both sides of 99"), std::string::npos)
      << ended.err;
  for (const char* option : {"--mesh", "--exact", "--level"}) {
    std::vector<std::string> call{"extract", file, "-i", "1", "--dataset", "density", option};
    if (option == std::string("--level")) call.push_back("1");
    ended = run(call);
    EXPECT_NE(ended.exit_code, 0) << option;
    EXPECT_NE(ended.err.find("isosplat build makes a scene of it"), std::string::npos) << ended.err;
  }
  ended = run({"extract", file, "-i", "1", "--dataset", "none"});
  EXPECT_NE(ended.exit_code, 0);
  EXPECT_NE(ended.err.find("density"), std::string::npos) << ended.err;
}

TEST(CliMesh, RefusesOptionsThatDoNotFit) {
  const TempFolder folder;
  const std::string a = folder / "a.vtu", b = folder / "b.vtu", out = folder / "c.isobundle";
  for (const auto& file : {a, b}) write_file(file, vtu_text(distance_mesh(Division::hexahedra)));
  const auto expect_refused = [&](std::vector<std::string> call, const std::string& message) {
    call.insert(call.begin(), "build");
    call.insert(call.end(), {"-o", out, "--no-thumbnail"});
    const auto ended = run(call);
    EXPECT_NE(ended.exit_code, 0);
    EXPECT_NE(ended.err.find(message), std::string::npos) << ended.err;
    EXPECT_FALSE(std::filesystem::exists(out));
  };
  expect_refused({a, "--time-step", "3"}, "a.vtu: a mesh has no time steps: remove --time-step");
  expect_refused({a, b}, "a.vtu: expected one adaptive or unstructured grid, found 2 files");
  EXPECT_EQ(run({"build", a, "--time-step", "0", "-o", out, "--no-thumbnail"}).exit_code, 0);
}

/// One error for each malformed file, within the memory of a small program.
TEST(CliMesh, RefusesMalformedFiles) {
  const TempFolder folder;
  UnstructuredMesh mesh;
  add_block(mesh, kUnit, {2, 1, 1}, Division::hexahedra);
  mesh_test::set_values(mesh, [](Vec3d p) { return p.x; });
  const std::string text = vtu_text(mesh), file = folder / "a.vtu";
  const struct {
    std::string from, to, message;
  } cases[] = {
      {"NumberOfPoints=\"12\"", "NumberOfPoints=\"1000000000000\"", "NumberOfPoints"},
      {"NumberOfPoints=\"12\"", "NumberOfPoints=\"4000000000\"", "raise --memory"},
      {"NumberOfPoints=\"12\"", "NumberOfPoints=\"13\"", "expected 39 values"},
      {"NumberOfPoints=\"12\"", "", "NumberOfPoints"},
      {"NumberOfCells=\"2\"", "NumberOfCells=\"1000000000\"", "raise --memory"},
      {"NumberOfCells=\"2\"", "NumberOfCells=\"3\"", "expected 3 values"},
      {"NumberOfCells=\"2\"", "NumberOfCells=\"-1\"", "NumberOfCells"},
      {"8\n16\n", "16\n8\n", "expected 8 points of cell 0"},
      {"8\n16\n", "8\n7\n", "expected offsets of cells that increase"},
      {"8\n16\n", "8\n99999999999\n", "expected offsets of cells"},
      {"8\n16\n", "8\n17\n", "expected 8 points of cell 1"},
      {"12\n12\n", "12\n25\n", "expected 20 points of cell 1 of type 25, found 8"},
      {"12\n12\n", "12\n66\n", "Tessellate"},
      {"12\n12\n", "67\n12\n", "Tessellate"},
      {"12\n12\n", "12\n41\n", "Tetrahedralize"},
      {"12\n12\n", "12\n42\n", "expected the array 'faceoffsets'"},
      {"12\n12\n", "12\n200\n", "expected types of cells"},
      {"12\n12\n", "12\n10\n", "expected 4 points of cell 1"},
      {"0 1 4 3", "0 1 4 12", "expected points of cells from 0 to 11, found 12 in cell 0"},
      {"0 1 4 3", "0 1 4 -3", "found -3 in cell 0"},
      {"<Points><DataArray type=\"Float64\" Name=\"Points\" NumberOfComponents=\"3\" "
       "format=\"ascii\">\n0",
       "<Points><DataArray type=\"Float64\" Name=\"Points\" NumberOfComponents=\"3\" "
       "format=\"ascii\">\nnan",
       "expected finite positions"},
      {"Name=\"connectivity\"", "Name=\"other\"", "'connectivity' in <Cells>"},
      {"<Points>", "<Pints>", "in <Points>"},
      {"</VTKFile>", "", "incomplete"},
      {"12\n12\n", "9\n9\n", "cells with values and a volume"},
  };
  for (const auto& each : cases) {
    std::string changed = text;
    const size_t at = changed.find(each.from);
    ASSERT_NE(at, changed.npos) << each.from;
    changed.replace(at, each.from.size(), each.to);
    write_file(file, changed);
    const auto ended = run({"build", file, "-o", folder / "b.isobundle", "--no-thumbnail"});
    EXPECT_EQ(ended.signal, 0) << each.to;
    EXPECT_NE(ended.exit_code, 0) << each.to;
    EXPECT_NE(ended.err.find(each.message), std::string::npos) << each.to << ": " << ended.err;
    EXPECT_FALSE(std::filesystem::exists(folder / "b.isobundle"));
  }
  write_file(file, text);
  const auto other = run({"build", file, "--dataset", "pressure"});
  EXPECT_NE(other.exit_code, 0);
  EXPECT_NE(other.err.find("expected one of 'density', 'where', 'number', found 'pressure'"),
            std::string::npos)
      << other.err;
}

}  // namespace
}  // namespace isosplat
