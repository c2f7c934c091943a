// isosplat build of curvilinear and unevenly spaced grids, whose cells become hexahedra.

#include <gtest/gtest.h>

#include <numbers>

#include "shared/core/unstructured/resample.h"
#include "shared/import/vtk_mesh/vtk_mesh.h"
#include "shared/system/scene_file/scene_file.h"
#include "tests/native/cli_program.h"
#include "tests/native/vtk_lattice_files.h"

namespace isosplat {
namespace {

using test::Lattice;
using test::run;
using test::TempFolder;
using test::vtr_text;
using test::vts_text;
using test::write_file;

double linear(Vec3d p) {
  return 3 * p.x - 2 * p.y + p.z + 5;
}

/// A ring around z: the radius along x from 1 to 2, the angle along y. Its first and last plane are
/// at the same place, up to rounding, or exactly.
Lattice ring(bool is_left_handed, bool is_exact) {
  Lattice of;
  of.low = {-2, 0, 5};
  of.high = {4, 24, 8};
  of.place = [=](Vec3d i) {
    const double turn = (is_exact && i.y == 24 ? 0 : i.y) / 24 * (is_left_handed ? -1 : 1);
    const double angle = 2 * std::numbers::pi * turn, radius = 1 + (i.x + 2) / 6;
    return Vec3d{radius * std::cos(angle), radius * std::sin(angle), (i.z - 5) / 6};
  };
  of.field = linear;
  return of;
}

/// Positions whose distances grow along each axis.
Lattice stretched() {
  Lattice of;
  of.low = {0, 0, 0};
  of.high = {8, 6, 5};
  of.place = [](Vec3d i) { return Vec3d{i.x + i.x * i.x / 8, 2 - i.y - i.y * i.y / 10, 3 * i.z}; };
  of.field = linear;
  return of;
}

Result<import::OpenMesh> open(const std::string& file, import::ImportOptions options = {}) {
  return import::open_vtk_mesh(file, options, uint64_t{1} << 30);
}

import::ImportOptions dataset(const std::string& name){import::ImportOptions options;
options.dataset = name;
return options;
}  // namespace

TEST(CliLattice, RingsHaveNoBorderWhereTheyClose) {
  const TempFolder folder;
  for (const bool is_left_handed : {false, true}) {
    for (const bool is_exact : {false, true}) {
      write_file(folder / "a.vts", vts_text(ring(is_left_handed, is_exact)));
      const auto opened = open(folder / "a.vts");
      ASSERT_TRUE(opened) << opened.error().message;
      EXPECT_EQ(opened->mesh.cells(), 6u * 24 * 3);
      const auto resampled = resample(opened->mesh, {});
      ASSERT_TRUE(resampled) << resampled.error().message;
      const ResampleError error = measure_error(opened->mesh, *resampled);
      EXPECT_LT(error.outside, 0.06);
      EXPECT_LT(error.rms, 0.005);
      for (int i = 0; i < 400; ++i) {
        // Around the plane where the ring closes, and at other angles.
        const double angle = (i % 20 - 10) * (i % 2 ? 0.01 : 0.3), radius = 1.15 + i / 20 * 0.035;
        const Vec3d at{radius * std::cos(angle), radius * std::sin(angle), 0.25};
        const auto value = value_at(*resampled, at);
        ASSERT_TRUE(value) << angle << ' ' << radius;
        EXPECT_NEAR(*value, linear(at), 0.05);
      }
      EXPECT_FALSE(value_at(*resampled, {0, 0, 0.25}));
      EXPECT_FALSE(value_at(*resampled, {1.7, 1.7, 0.25}));
    }
  }
}

/// Cells on both sides of the plane where a ring closes have a part in the values there.
TEST(CliLattice, ValuesOfCellsAreContinuousWhereARingCloses) {
  for (const bool is_exact : {true, false}) {
    const TempFolder folder;
    write_file(folder / "a.vts", vts_text(ring(false, is_exact)));
    const auto opened = open(folder / "a.vts", dataset("mean"));
    ASSERT_TRUE(opened) << opened.error().message;
    const auto& values = opened->mesh.values;
    for (size_t z = 0; z < 4; ++z) {
      for (size_t x = 0; x < 7; ++x) {
        const size_t first = (z * 25 + 0) * 7 + x, last = (z * 25 + 24) * 7 + x;
        EXPECT_EQ(values[first], values[last]) << is_exact;
        // −2 y is positive on one side of the plane, and negative on the other.
        EXPECT_NEAR(values[first], linear(opened->mesh.points[first]),
                    x == 0 || x == 6 ? 0.6 : 0.3);
      }
    }
  }
}

TEST(CliLattice, UnevenAxesAreExact) {
  const TempFolder folder;
  write_file(folder / "a.vtr", vtr_text(stretched()));
  const auto opened = open(folder / "a.vtr");
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_EQ(opened->mesh.cells(), 8u * 6 * 5);
  const auto resampled = resample(opened->mesh, {});
  ASSERT_TRUE(resampled) << resampled.error().message;
  const ResampleError error = measure_error(opened->mesh, *resampled);
  EXPECT_LT(error.max, 1e-6);
  EXPECT_EQ(error.outside, 0);
  for (int i = 0; i < 200; ++i) {
    const Vec3d at{0.1 + 15.8 * (i % 7) / 7, -7.5 + 9.4 * (i % 11) / 11,
                   0.1 + 14.8 * (i % 13) / 13};
    const auto value = value_at(*resampled, at);
    ASSERT_TRUE(value);
    EXPECT_NEAR(*value, linear(at), 1e-6);
  }
  const auto ended = run({"build", folder / "a.vtr", "--no-thumbnail"});
  ASSERT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_NE(ended.err.find("240 cells of a mesh became"), std::string::npos) << ended.err;
  EXPECT_TRUE(SceneFile::open(folder / "a.isobundle"));
  const auto info = run({"info", folder / "a.vtr"});
  EXPECT_NE(
      info.err.find("expected evenly spaced coordinates along x, found others: isosplat build "
                    "makes a scene of this grid"),
      std::string::npos)
      << info.err;
}

TEST(CliLattice, EvenAxesAreStillAVolume) {
  const TempFolder folder;
  Lattice of = stretched();
  of.place = [](Vec3d i) { return Vec3d{i.x, 2 - i.y, 3 * i.z}; };
  write_file(folder / "a.vtr", vtr_text(of));
  const auto ended = run({"build", folder / "a.vtr", "--no-thumbnail"});
  ASSERT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_TRUE(std::filesystem::exists(folder / "a.isosplat"));
  EXPECT_FALSE(std::filesystem::exists(folder / "a.isobundle"));
}

TEST(CliLattice, HiddenCellsAndCellsAtHiddenPointsAreLeftOut) {
  const TempFolder folder;
  const struct {
    const char* array;
    bool of_cells;
    std::vector<std::pair<size_t, int>> flags;
    uint64_t left_out;
  } cases[] = {
      {"vtkGhostType", true, {{0, 1}, {7, 32}, {8, 16}}, 2},
      {"vtkGhostLevels", true, {{3, 1}}, 1},
      {"vtkGhostType", false, {{0, 2}}, 1},   // the corner of one cell
      {"vtkGhostType", false, {{13, 2}}, 8},  // the point in the middle of 2³ cells
      {"vtkGhostType", false, {{13, 1}}, 0},  // another piece has the point too
      {"vtkGhostLevels", false, {{13, 1}}, 0},
  };
  for (const auto& each : cases) {
    Lattice of;
    of.high = {2, 2, 2};
    std::vector<int> all(each.of_cells ? 8 : 27);
    if (each.of_cells && each.flags.size() > 1) {
      of.high = {3, 2, 2};
      all.resize(12);
    }
    for (const auto& [item, flag] : each.flags) all[item] = flag;
    (each.of_cells ? of.cell_arrays : of.point_arrays) =
        test::vtk_array("UInt8", each.array, 1, fmt::format("{}", fmt::join(all, " ")));
    for (const bool is_rectilinear : {false, true}) {
      write_file(folder / "a", is_rectilinear ? vtr_text(of) : vts_text(of));
      const auto opened = open(folder / "a");
      ASSERT_TRUE(opened) << opened.error().message;
      const size_t cells = each.of_cells && each.flags.size() > 1 ? 12 : 8;
      EXPECT_EQ(opened->mesh.cells(), cells - each.left_out) << each.array;
    }
  }
}

/// The pieces' files have more points than the parts that the main file names.
TEST(CliLattice, PiecesAreJoinedWithoutTheirGhostLevels) {
  const TempFolder folder;
  for (const bool is_rectilinear : {false, true}) {
    const Lattice whole = is_rectilinear ? stretched() : ring(false, true);
    const std::string type = is_rectilinear ? "PRectilinearGrid" : "PStructuredGrid";
    std::string pieces;
    for (int i = 0; i < 2; ++i) {
      Lattice named = whole, stored = whole;
      (i ? named.low : named.high)[1] = 3;
      (i ? stored.low : stored.high)[1] = i ? 2 : 5;
      const std::string name = fmt::format("p{}", i);
      write_file(folder / name, is_rectilinear ? vtr_text(stored) : vts_text(stored));
      pieces += fmt::format("<Piece Extent=\"{}\" Source=\"{}\"/>", vtk_extent(named), name);
    }
    write_file(folder / "all", fmt::format("<VTKFile type=\"{0}\" version=\"1.0\"><{0} "
                                           "WholeExtent=\"{1}\">{2}</{0}></VTKFile>",
                                           type, vtk_extent(whole), pieces));
    for (const char* name : {"density", "mean"}) {
      const auto opened = open(folder / "all", dataset(name));
      ASSERT_TRUE(opened) << opened.error().message;
      write_file(folder / "one", is_rectilinear ? vtr_text(whole) : vts_text(whole));
      const auto one = open(folder / "one", dataset(name));
      ASSERT_TRUE(one) << one.error().message;
      EXPECT_EQ(opened->mesh.cells(), one->mesh.cells());
      EXPECT_EQ(opened->files.size(), 3u);
      // The same function, as pieces have no borders between them.
      const auto joined = resample(opened->mesh, {}), expected = resample(one->mesh, {});
      ASSERT_TRUE(joined && expected);
      for (int i = 0; i < 200; ++i) {
        const auto& points = one->mesh.points;
        const Vec3d at = (points[static_cast<size_t>(i * 7) % points.size()] * 0.4 +
                          points[static_cast<size_t>(i * 7 + 8) % points.size()] * 0.6);
        const auto a = value_at(*joined, at), b = value_at(*expected, at);
        ASSERT_EQ(a.has_value(), b.has_value());
        if (a) {
          EXPECT_NEAR(*a, *b, 1e-9);
        }
      }
    }
  }
}

TEST(CliLattice, RefusesWhatIsNoVolume) {
  const TempFolder folder;
  Lattice flat = stretched();
  flat.high[2] = 0;
  for (const bool is_rectilinear : {false, true}) {
    const std::string file = folder / (is_rectilinear ? "a.vtr" : "a.vts");
    write_file(file, is_rectilinear ? vtr_text(flat) : vts_text(flat));
    const auto ended = run({"build", file, "--no-thumbnail"});
    EXPECT_NE(ended.exit_code, 0);
    if (is_rectilinear) continue;  // as before: a volume with one slice
    EXPECT_NE(
        ended.err.find("expected a grid of three dimensions, with at least 2 points along each "
                       "axis, found 9×7×1 points"),
        std::string::npos)
        << ended.err;
  }
}

TEST(CliLattice, RefusesMalformedFiles) {
  const TempFolder folder;
  Lattice of = stretched();
  of.high = {2, 2, 1};
  const std::string curved = vts_text(of), uneven = vtr_text(of);
  const struct {
    const std::string& text;
    std::string from, to, message;
  } cases[] = {
      {curved, "Extent=\"0 2 0 2 0 1\"", "Extent=\"0 3 0 2 0 1\"",
       "expected 72 values in the array 'Points', found 54"},
      {curved, "Extent=\"0 2 0 2 0 1\"", "Extent=\"0 2000000000 0 2000000000 0 2000000000\"",
       "raise --memory"},
      {curved, "Extent=\"0 2 0 2 0 1\"", "Extent=\"-2147483648 2147483648 0 2 0 1\"",
       "raise --memory"},
      {curved, "Extent=\"0 2 0 2 0 1\"", "Extent=\"0 2 0 2\"", "6 whole numbers in Extent"},
      {curved, "WholeExtent=\"0 2 0 2 0 1\"", "WholeExtent=\"5 7 0 2 0 1\"",
       "expected points and cells, found none"},
      {curved, "WholeExtent=\"0 2 0 2 0 1\"", "", "6 whole numbers in WholeExtent"},
      {curved, "<Points>", "<Pints>", "in <Points>"},
      {curved, "\"Points\" NumberOfComponents=\"3\"", "\"Points\" NumberOfComponents=\"2\"",
       "in <Points>"},
      {curved, "</VTKFile>", "", "incomplete"},
      {uneven, "0 1.125", "0 nan", "expected finite coordinates along x"},
      {uneven, "0 1.125", "0 3.5", "that increase or decrease from each to the next"},
      {uneven, "0 1.125", "0 0", "that increase or decrease from each to the next"},
      {uneven, "<Piece Extent=\"0 2 0 2 0 1\"", "<Piece Extent=\"0 2 0 1 0 1\"", "values"},
  };
  for (const auto& each : cases) {
    std::string changed = each.text;
    const bool is_piece = each.from.starts_with("Extent");
    const std::string from = is_piece ? "<Piece " + each.from : each.from;
    const size_t at = changed.find(from);
    ASSERT_NE(at, changed.npos) << from;
    changed.replace(at, from.size(), is_piece ? "<Piece " + each.to : each.to);
    if (is_piece && each.to.find("000") != each.to.npos) {  // the whole extent too
      const size_t whole = changed.find(each.from);
      ASSERT_NE(whole, changed.npos);
      changed.replace(whole, each.from.size(), each.to);
    }
    const std::string file = folder / "a.vts";
    write_file(file, changed);
    const auto ended = run({"build", file, "-o", folder / "b.isobundle", "--no-thumbnail"});
    EXPECT_EQ(ended.signal, 0) << each.to;
    EXPECT_NE(ended.exit_code, 0) << each.to;
    EXPECT_NE(ended.err.find(each.message), std::string::npos) << each.to << ": " << ended.err;
    EXPECT_FALSE(std::filesystem::exists(folder / "b.isobundle"));
  }
}

}  // namespace isosplat
}  // namespace isosplat
