// isosplat build of meshes with quadratic cells, prisms and polyhedra, which are divided.

#include <gtest/gtest.h>

#include <algorithm>

#include "shared/core/unstructured/boundary_faces.h"
#include "shared/core/unstructured/resample.h"
#include "shared/import/vtk_mesh/vtk_mesh.h"
#include "tests/native/cli_program.h"
#include "tests/native/vtk_cell_files.h"

namespace isosplat {
namespace {

using test::CellFile;
using test::run;
using test::TempFolder;
using test::write_file;

double linear(Vec3d p) {
  return 3 * p.x - 2 * p.y + p.z + 5;
}

double waves(Vec3d p) {
  return std::sin(3 * p.x) * std::cos(2 * p.y) + p.z * p.z;
}

/// Bends the unit cube.
Vec3d bent(Vec3d p) {
  return {p.x + 0.1 * p.y * p.y, p.y + 0.1 * p.z * p.z, p.z + 0.1 * p.x * p.x};
}

Result<import::OpenMesh> open(const CellFile& of, import::ImportOptions options = {}) {
  const TempFolder folder;
  write_file(folder / "a.vtu", of.text());
  return import::open_vtk_mesh(folder / "a.vtu", options, uint64_t{1} << 30);
}

double volume(const UnstructuredMesh& mesh) {
  double sum = 0;
  for (size_t cell = 0; cell < mesh.cells(); ++cell) sum += volume_of(mesh.geometry(cell));
  return sum;
}

/// The largest difference between the values of cells at a point on each of their faces. `alone`:
/// becomes the number of faces with a point in one cell only.
double jump_at_faces(const UnstructuredMesh& mesh, size_t& alone) {
  double most = 0;
  alone = 0;
  for (size_t cell = 0; cell < mesh.cells(); ++cell) {
    for (uint8_t face = 0; face < faces_of(mesh.shapes[cell]).size(); ++face) {
      const FaceCorners of = corners_of(mesh, {static_cast<uint32_t>(cell), face});
      const double share[4] = {0.28, 0.42, of.count == 3 ? 0.3 : 0.18, 0.12};  // bilinear: 0.3, 0.6
      Vec3d point{0, 0, 0};
      for (size_t i = 0; i < of.count; ++i) point = point + of.at[i] * share[i];
      double low = 1e9, high = -1e9;
      size_t found = 0;
      for (size_t other = 0; other < mesh.cells(); ++other) {
        const auto weights = weights_in_cell(mesh.geometry(other), point);
        if (!weights) continue;
        ++found;
        low = std::min(low, mesh.value(other, *weights));
        high = std::max(high, mesh.value(other, *weights));
      }
      EXPECT_GE(found, 1u);
      if (found == 1) ++alone;
      most = std::max(most, high - low);
    }
  }
  return most;
}

/// Cells of one type in 2³ boxes of the unit cube, and the faces on its surface after the division.
struct Kind {
  int type = 0;
  size_t parts = 0, border = 0;
};
constexpr Kind kKinds[] = {
    {24, 8 * 6 * 8, 6 * 4 * 8},       {25, 8 * 8, 6 * 16}, {26, 8 * 2 * 8, 2 * 32 + 4 * 16},
    {27, 8 * 6 * 10, 6 * 16},         {29, 8 * 8, 6 * 16}, {31, 8 * 2 * 4, 2 * 32 + 4 * 8},
    {32, 8 * 2 * 8, 2 * 32 + 4 * 16}, {33, 8 * 8, 6 * 16}, {12, 8, 6 * 4}};

TEST(CliCells, DividedCellsShareTheirFaces) {
  for (const Kind& kind : kKinds) {
    SCOPED_TRACE(kind.type);
    for (const bool is_bent : {false, true}) {
      const auto opened = open(test::block_of(kind.type, 2, is_bent ? bent : nullptr, waves));
      ASSERT_TRUE(opened) << opened.error().message;
      const UnstructuredMesh& mesh = opened->mesh;
      EXPECT_EQ(mesh.cells(), kind.parts);
      ASSERT_EQ(mesh.values.size(), mesh.points.size());
      if (!is_bent) {
        EXPECT_NEAR(volume(mesh), 1, 1e-9);
      }
      size_t alone = 0;
      EXPECT_LT(jump_at_faces(mesh, alone), 1e-4);
      EXPECT_EQ(alone, kind.border);
    }
  }
}

/// The quadratic functions of the nodes; their points in the middle of faces have their values too.
TEST(CliCells, PointsInTheMiddleHaveTheQuadraticValue) {
  const auto square = [](Vec3d p) { return p.x * p.x - 2 * p.y * p.z + p.z; };
  for (const int type : {25, 26, 27, 33}) {
    const auto opened = open(test::block_of(type, 1, nullptr, square));
    ASSERT_TRUE(opened) << opened.error().message;
    for (size_t i = 0; i < opened->mesh.points.size(); ++i) {
      EXPECT_NEAR(opened->mesh.values[i], square(opened->mesh.points[i]), 1e-12) << type;
    }
  }
}

/// The largest difference between the function of a mesh and a field, at points in the unit cube.
double largest_difference(const UnstructuredMesh& mesh, double (*field)(Vec3d)) {
  double most = 0;
  for (int i = 0; i < 4096; ++i) {
    const Vec3d at{(i % 16 + 0.5) / 16, (i / 16 % 16 + 0.5) / 16, (i / 256 + 0.5) / 16};
    for (size_t cell = 0; cell < mesh.cells(); ++cell) {
      const auto weights = weights_in_cell(mesh.geometry(cell), at);
      if (!weights) continue;
      most = std::max(most, std::abs(mesh.value(cell, *weights) - field(at)));
      break;
    }
  }
  return most;
}

/// Quadratic cells have this function exactly, so the difference is that of the division.
TEST(CliCells, TheDivisionHasAQuarterOfTheErrorOfLinearCells) {
  const auto square = [](Vec3d p) { return p.x * p.x - 2 * p.y * p.y + p.z * p.z / 2 + p.z; };
  for (const auto& [quadratic, linear_type] : {std::pair{24, 10}, {25, 12}, {26, 13}, {27, 14}}) {
    CellFile of = test::block_of(quadratic, 2, nullptr, square);
    const auto divided = open(of);
    ASSERT_TRUE(divided) << divided.error().message;
    constexpr size_t kCorners[] = {4, 0, 8, 6, 5};
    for (auto& cell : of.cells) {
      cell.type = linear_type;
      cell.nodes.resize(kCorners[linear_type - 10]);
    }
    const auto linear_cells = open(of);
    ASSERT_TRUE(linear_cells) << linear_cells.error().message;
    const double ratio =
        largest_difference(divided->mesh, square) / largest_difference(linear_cells->mesh, square);
    EXPECT_GT(ratio, 0.15) << quadratic;
    EXPECT_LT(ratio, 0.3) << quadratic;
  }
}

TEST(CliCells, LinearFunctionsAreExact) {
  for (const Kind& kind : kKinds) {
    SCOPED_TRACE(kind.type);
    const auto opened = open(test::block_of(kind.type, 2, bent, linear));
    ASSERT_TRUE(opened) << opened.error().message;
    const auto resampled = resample(opened->mesh, {});
    ASSERT_TRUE(resampled) << resampled.error().message;
    EXPECT_LT(measure_error(opened->mesh, *resampled).max, 1e-6);
    const auto straight = open(test::block_of(kind.type, 2, nullptr, linear));
    const auto exact = resample(straight->mesh, {});
    ASSERT_TRUE(exact);
    const ResampleError error = measure_error(straight->mesh, *exact);
    EXPECT_LT(error.max, 1e-6);
    EXPECT_EQ(error.outside, 0);
  }
}

/// Prisms and the polyhedra of the same faces are divided in the same way.
TEST(CliCells, PrismsArePolyhedra) {
  for (const size_t sides : {size_t{5}, size_t{6}}) {
    const CellFile prisms = test::stacked_prisms(sides, false, linear);
    const auto opened = open(prisms);
    ASSERT_TRUE(opened) << opened.error().message;
    const UnstructuredMesh& mesh = opened->mesh;
    EXPECT_EQ(mesh.cells(), 2 * (sides + 2 * sides));
    const double angle = 2 * std::numbers::pi / static_cast<double>(sides);
    EXPECT_NEAR(volume(mesh), 2 * std::sin(angle) / 2 * static_cast<double>(sides), 1e-9);
    size_t alone = 0;
    EXPECT_LT(jump_at_faces(mesh, alone), 1e-5);
    EXPECT_EQ(alone, 2 * sides + 2 * sides);
    for (size_t i = 0; i < mesh.points.size(); ++i) {
      EXPECT_NEAR(mesh.values[i], linear(mesh.points[i]), 1e-12);
    }
    const auto same = open(test::stacked_prisms(sides, true, linear));
    ASSERT_TRUE(same) << same.error().message;
    EXPECT_EQ(same->mesh.points, mesh.points);
    EXPECT_EQ(same->mesh.corners, mesh.corners);
  }
}

/// Faces of four corners have the bilinear function, so polyhedra and hexahedra share it.
TEST(CliCells, PolyhedraAndHexahedraShareTheirFaces) {
  CellFile of = test::block_of(12, 2, bent, waves);
  for (size_t i = 0; i < of.cells.size(); i += 3) test::make_polyhedron(of.cells[i]);
  const auto opened = open(of);
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_EQ(opened->mesh.cells(), 5u + 3 * 6);
  size_t alone = 0;
  EXPECT_LT(jump_at_faces(opened->mesh, alone), 1e-4);
  EXPECT_EQ(alone, 24u);
}

/// All parts of a cell have its value, and belong to it if it is left out.
TEST(CliCells, ValuesOfCellsAreThoseOfTheirParts) {
  import::ImportOptions options;
  options.dataset = "number";
  for (const int type : {25, 42}) {
    CellFile of = test::block_of(type == 25 ? 25 : 12, 2, nullptr, linear);
    if (type == 42) {
      for (auto& cell : of.cells) test::make_polyhedron(cell);
    }
    const auto all = open(of, options);
    ASSERT_TRUE(all) << all.error().message;
    EXPECT_NEAR(*std::ranges::max_element(all->mesh.values), 7, 1e-9);
    EXPECT_NEAR(*std::ranges::min_element(all->mesh.values), 0, 1e-9);
    options.missing_value = 5;
    const auto fewer = open(of, options);
    ASSERT_TRUE(fewer);
    EXPECT_EQ(fewer->mesh.cells(), all->mesh.cells() / 8 * 7);
    EXPECT_NEAR(volume(fewer->mesh), 7.0 / 8, 1e-9);
    EXPECT_NE(std::ranges::find(fewer->notes, "1 cells have no value: they are left out"),
              fewer->notes.end());
    options.missing_value.reset();
    of.cell_flags = "0 0 0 32 0 0 0 0";
    const auto hidden = open(of, options);
    ASSERT_TRUE(hidden);
    EXPECT_EQ(hidden->mesh.cells(), all->mesh.cells() / 8 * 7);
  }
}

TEST(CliCells, NamesTheCellsOfTheFile) {
  const TempFolder folder;
  write_file(folder / "a.vtu", test::block_of(25, 2, bent, waves).text());
  const auto ended = run({"build", folder / "a.vtu", "--no-thumbnail", "--dataset", "density"});
  ASSERT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_NE(ended.err.find("8 cells, which are quadratic or polyhedra, were divided into 64 linear "
                           "ones"),
            std::string::npos)
      << ended.err;
}

TEST(CliCells, TablesOfFacesAreReadAsTheOlderLayout) {
  CellFile of = test::block_of(12, 2, nullptr, linear);
  for (size_t i = 0; i < of.cells.size(); i += 2) test::make_polyhedron(of.cells[i]);
  const auto older = open(of);
  of.has_tables = true;
  ASSERT_NE(of.text().find("polyhedron_to_faces"), std::string::npos);
  const auto opened = open(of);
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_EQ(opened->mesh.cells(), 4u + 4 * 6);
  EXPECT_EQ(opened->mesh.shapes, older->mesh.shapes);
  EXPECT_EQ(opened->mesh.corners, older->mesh.corners);
}

TEST(CliCells, RefusesMalformedTablesOfFaces) {
  const TempFolder folder;
  CellFile of = test::block_of(12, 1, nullptr, linear);
  test::make_polyhedron(of.cells[0]);
  of.has_tables = true;
  const std::string text = of.text();
  const struct {
    std::string from, to, message;
  } cases[] = {
      {"\n6 \n", "\n7 \n", "expected 7 values in the array 'polyhedron_to_faces'"},
      {"\n6 \n", "\n-1 \n", "increase, from 0 on in the array 'polyhedron_offsets', found -1"},
      {"\n6 \n", "\n3 \n", "expected 3 values in the array 'polyhedron_to_faces'"},
      {"\n6 \n", "\n4000000000 \n", "raise --memory"},
      {"\n5 4 3 ", "\n6 4 3 ", "expected 7 values in the array 'face_offsets'"},
      {"\n5 4 3 ", "\n-5 4 3 ", "numbers from 0 on in the array 'polyhedron_to_faces', found -5"},
      {"\n5 4 3 ", "\n4000000000 4 3 ", "raise --memory"},
      {"\n4 8 12 ", "\n4 3 12 ", "increase, from 0 on in the array 'face_offsets', found 3"},
      {"\n4 8 12 ", "\n2 8 12 ", "expected the faces of cell 0"},
      {"16 20 24 ", "16 20 25 ", "expected 25 values in the array 'face_connectivity'"},
      {"Name=\"face_offsets\"", "Name=\"other\"", "expected the array 'face_offsets'"},
      {"Name=\"polyhedron_offsets\"", "Name=\"other\"", "expected the array 'polyhedron_offsets'"},
  };
  for (const auto& each : cases) {
    std::string changed = text;
    const size_t at = changed.find(each.from);
    ASSERT_NE(at, changed.npos) << each.from;
    changed.replace(at, each.from.size(), each.to);
    write_file(folder / "a.vtu", changed);
    const auto ended = run({"build", folder / "a.vtu", "-o", folder / "b.isobundle"});
    EXPECT_EQ(ended.signal, 0) << each.to;
    EXPECT_NE(ended.exit_code, 0) << each.to;
    EXPECT_NE(ended.err.find(each.message), std::string::npos) << each.to << ": " << ended.err;
  }
}

TEST(CliCells, RefusesMalformedPolyhedra) {
  const TempFolder folder;
  CellFile of = test::block_of(12, 1, nullptr, linear);
  test::make_polyhedron(of.cells[0]);
  const std::string text = of.text();
  const std::string faces = "6 4 0 4 7 3 ";
  const struct {
    std::string from, to, message;
  } cases[] = {
      {faces, "5 4 0 4 7 3 ", "expected the faces of cell 0"},
      {faces, "7 4 0 4 7 3 ", "expected the faces of cell 0"},
      {faces, "6 2 0 4 7 3 ", "expected the faces of cell 0"},
      {faces, "6 4294967295 0 4 7 3 ", "expected the faces of cell 0"},
      {faces, "6 4 0 4 8 3 ", "expected points of cells from 0 to 7, found 8 in cell 0"},
      {faces, "6 4 0 4 -7 3 ", "expected points of cells from 0 to 7"},
      {faces, "6 4 0 4 3 ", "expected 31 values in the array 'faces'"},
      {"Name=\"faces\"", "Name=\"other\"", "expected the array 'faces'"},
      {"Name=\"faceoffsets\"", "Name=\"other\"", "expected the array 'faceoffsets'"},
      {"\n31 \n", "\n-1 \n", "expected faceoffsets that increase"},
      {"\n31 \n", "\n99999999999 \n", "expected faceoffsets that increase"},
      {"\n31 \n", "\n4000000000 \n", "raise --memory"},
      {"\n31 \n", "\n0 \n", "expected the faces of cell 0"},
      {"\n8 \n", "\n3 \n", "expected at least 4 points of cell 0, a polyhedron"},
      {"\n42 \n", "\n41 \n", "Tetrahedralize"},
      {"\n42 \n", "\n25 \n", "expected 20 points of cell 0 of type 25, found 8"},
  };
  for (const auto& each : cases) {
    std::string changed = text;
    const size_t at = changed.find(each.from);
    ASSERT_NE(at, changed.npos) << each.from;
    changed.replace(at, each.from.size(), each.to);
    write_file(folder / "a.vtu", changed);
    const auto ended = run({"build", folder / "a.vtu", "-o", folder / "b.isobundle"});
    EXPECT_EQ(ended.signal, 0) << each.to;
    EXPECT_NE(ended.exit_code, 0) << each.to;
    EXPECT_NE(ended.err.find(each.message), std::string::npos) << each.to << ": " << ended.err;
  }
}

}  // namespace
}  // namespace isosplat
