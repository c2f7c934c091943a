// isosplat build of meshes in legacy VTK files: the same meshes as those of the XML format.

#include <gtest/gtest.h>

#include "shared/import/open_volume.h"
#include "shared/import/vtk_mesh/vtk_mesh.h"
#include "tests/native/cli_program.h"
#include "tests/native/volume_files.h"
#include "tests/native/vtk_cell_files.h"
#include "tests/native/vtk_lattice_files.h"

namespace isosplat {
namespace {

using test::CellFile;
using test::Lattice;
using test::run;
using test::TempFolder;
using test::write_file;

enum class Form { text, binary, text_5, binary_5 };  // 5: from version 5 on
constexpr Form kForms[] = {Form::text, Form::binary, Form::text_5, Form::binary_5};

bool is_binary(Form form) {
  return form == Form::binary || form == Form::binary_5;
}

bool is_5(Form form) {
  return form == Form::text_5 || form == Form::binary_5;
}

/// Numbers as text, or in big-endian order.
template <class T>
std::string numbers(Form form, const std::vector<T>& of) {
  std::string text;
  for (const T each : of) {
    if (!is_binary(form)) {
      text += fmt::format("{} ", each);
      continue;
    }
    char bytes[sizeof(T)];
    std::memcpy(bytes, &each, sizeof(T));
    std::reverse(std::begin(bytes), std::end(bytes));
    text.append(bytes, sizeof(T));
  }
  return text + "\n";
}

std::string header(Form form, const std::string& dataset) {
  return fmt::format("# vtk DataFile Version {}\nmesh\n{}\nDATASET {}\n",
                     is_5(form) ? "5.1" : "3.0", is_binary(form) ? "BINARY" : "ASCII", dataset);
}

std::string data(Form form, const std::vector<double>& points, const std::vector<double>& cells) {
  return fmt::format("CELL_DATA {}\nFIELD FieldData 1\nmean 1 {} double\n", cells.size(),
                     cells.size()) +
         numbers(form, cells) +
         fmt::format("POINT_DATA {}\nSCALARS density double 1\nLOOKUP_TABLE default\n",
                     points.size()) +
         numbers(form, points);
}

std::string points_section(Form form, const std::vector<Vec3d>& points) {
  std::vector<double> all;
  for (const Vec3d p : points) all.insert(all.end(), {p.x, p.y, p.z});
  return fmt::format("POINTS {} double\n", points.size()) + numbers(form, all);
}

std::string legacy_text(Form form, const CellFile& of) {
  std::vector<int32_t> counts, types;
  std::vector<int64_t> offsets{0}, nodes;
  std::vector<double> cell_values;
  for (const auto& cell : of.cells) {
    std::vector<size_t> all = cell.nodes;
    if (cell.type == 42) {
      all = {cell.faces.size()};
      for (const auto& face : cell.faces) {
        all.push_back(face.size());
        all.insert(all.end(), face.begin(), face.end());
      }
    }
    counts.push_back(static_cast<int32_t>(all.size()));
    for (const size_t node : all) {
      counts.push_back(static_cast<int32_t>(node));
      nodes.push_back(static_cast<int64_t>(node));
    }
    offsets.push_back(static_cast<int64_t>(nodes.size()));
    types.push_back(cell.type);
    cell_values.push_back(static_cast<double>(cell_values.size()));
  }
  std::string cells =
      fmt::format("CELLS {} {}\n", of.cells.size(), counts.size()) + numbers(form, counts);
  if (is_5(form)) {
    cells = fmt::format("CELLS {} {}\nOFFSETS vtktypeint64\n", offsets.size(), nodes.size()) +
            numbers(form, offsets) + "CONNECTIVITY vtktypeint64\n" + numbers(form, nodes);
  }
  return header(form, "UNSTRUCTURED_GRID") + points_section(form, of.points) + cells +
         fmt::format("CELL_TYPES {}\n", types.size()) + numbers(form, types) +
         data(form, of.values, cell_values);
}

std::string legacy_text(Form form, const Lattice& of, bool is_rectilinear) {
  std::vector<Vec3d> points;
  std::vector<double> values, cells;
  test::for_each_index(of, 1, [&](Vec3d i) {
    points.push_back(of.place(i));
    values.push_back(of.field(points.back()));
  });
  test::for_each_index(of, 0, [&](Vec3d) { cells.push_back(static_cast<double>(cells.size())); });
  std::string text =
      header(form, is_rectilinear ? "RECTILINEAR_GRID" : "STRUCTURED_GRID") +
      fmt::format("DIMENSIONS {} {} {}\n", of.high[0] + 1, of.high[1] + 1, of.high[2] + 1);
  if (!is_rectilinear) return text + points_section(form, points) + data(form, values, cells);
  for (size_t axis = 0; axis < 3; ++axis) {
    std::vector<double> along;
    for (int i = 0; i <= of.high[axis]; ++i) {
      const Vec3d at = of.place({1. * i, 1. * i, 1. * i});
      along.push_back(axis == 0 ? at.x : axis == 1 ? at.y : at.z);
    }
    text +=
        fmt::format("{}_COORDINATES {} double\n", "XYZ"[axis], along.size()) + numbers(form, along);
  }
  return text + data(form, values, cells);
}

Lattice lattice(bool is_even) {
  Lattice of;
  of.high = {4, 3, 2};
  of.place = [=](Vec3d i) {
    return is_even ? Vec3d{i.x, 5 - i.y, 2 * i.z} : Vec3d{i.x + i.x * i.x / 8, 5 - i.y, 2 * i.z};
  };
  of.field = [](Vec3d p) { return 3 * p.x - 2 * p.y + p.z; };
  return of;
}

void expect_same(const std::string& legacy, const std::string& xml, const std::string& of_cells) {
  const TempFolder folder;
  write_file(folder / "a.vtk", legacy);
  write_file(folder / "b.vtu", xml);
  const auto found = import::open_vtk_mesh(folder / "a.vtk", {}, uint64_t{1} << 30);
  const auto expected = import::open_vtk_mesh(folder / "b.vtu", {}, uint64_t{1} << 30);
  ASSERT_TRUE(found) << found.error().message;
  ASSERT_TRUE(expected) << expected.error().message;
  EXPECT_EQ(found->mesh.points, expected->mesh.points);
  EXPECT_EQ(found->mesh.values, expected->mesh.values);
  EXPECT_EQ(found->mesh.shapes, expected->mesh.shapes);
  EXPECT_EQ(found->mesh.corners, expected->mesh.corners);
  EXPECT_GT(found->mesh.cells(), 0u);
  EXPECT_EQ(found->format, "VTK");
  import::ImportOptions options;
  options.dataset = of_cells;
  const auto cells = import::open_vtk_mesh(folder / "a.vtk", options, uint64_t{1} << 30);
  ASSERT_TRUE(cells) << cells.error().message;
  EXPECT_NE(cells->mesh.values, found->mesh.values);
}

TEST(CliLegacyMesh, CellsAreThoseOfTheXmlFile) {
  const auto field = [](Vec3d p) { return p.x * p.x + p.y - p.z; };
  for (const Form form : kForms) {
    for (const int type : {12, 24, 25, 26, 27}) {
      const CellFile of = test::block_of(type, 2, nullptr, field);
      expect_same(legacy_text(form, of), of.text(), "mean");
    }
    CellFile polyhedra = test::block_of(12, 2, nullptr, field);
    for (auto& cell : polyhedra.cells) test::make_polyhedron(cell);
    expect_same(legacy_text(form, polyhedra), polyhedra.text(), "mean");
  }
}

TEST(CliLegacyMesh, LatticesAreThoseOfTheXmlFile) {
  for (const Form form : kForms) {
    const Lattice of = lattice(false);
    expect_same(legacy_text(form, of, false), test::vts_text(of), "mean");
    expect_same(legacy_text(form, of, true), test::vtr_text(of), "mean");
  }
}

TEST(CliLegacyMesh, EvenAxesAreAVolume) {
  for (const Form form : kForms) {
    const TempFolder folder;
    write_file(folder / "a.vtk", legacy_text(form, lattice(true), true));
    const auto ended = run({"build", folder / "a.vtk", "--no-thumbnail"});
    ASSERT_EQ(ended.exit_code, 0) << ended.err;
    EXPECT_TRUE(std::filesystem::exists(folder / "a.isosplat"));
    const auto volume = import::open_volume(folder / "a.vtk", {});
    ASSERT_TRUE(volume) << volume.error().message;
    const VolumeGrid& grid = volume->source->header().grid;
    EXPECT_EQ(grid.voxels, (Index3{5, 4, 3}));
    EXPECT_EQ(grid.spacing, (Vec3d{1, 1, 2}));
    EXPECT_EQ(grid.origin, (Vec3d{0, 2, 0}));
  }
}

TEST(CliLegacyMesh, BuildsAScene) {
  const TempFolder folder;
  write_file(folder / "a.vtk",
             legacy_text(Form::binary_5,
                         test::block_of(25, 3, nullptr, [](Vec3d p) { return p.x * p.x + p.y; })));
  const auto ended = run({"build", folder / "a.vtk", "--no-thumbnail"});
  ASSERT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_TRUE(std::filesystem::exists(folder / "a.isobundle"));
  const auto info = run({"info", folder / "a.vtk"});
  EXPECT_NE(info.exit_code, 0);
  EXPECT_NE(info.err.find("found unstructured_grid: only regular grids are volumes; isosplat build "
                          "makes a scene of it"),
            std::string::npos)
      << info.err;
}

/// A string in binary files: a length below 64 has one byte.
std::string string_of(Form form, const std::string& text) {
  return is_binary(form) ? static_cast<char>(0xc0 | text.size()) + text : text + "\n";
}

/// Arrays of other kinds before those that are read, as VTK's writers write them.
TEST(CliLegacyMesh, OtherSectionsAreSkippedAndNamesAreDecoded) {
  const auto field = [](Vec3d p) { return p.x * p.x + p.y - p.z; };
  for (const Form form : kForms) {
    const CellFile of = test::block_of(12, 2, nullptr, field);
    const size_t points = of.points.size(), cells = of.cells.size();
    std::string text = legacy_text(form, of);
    text.resize(text.find("CELL_DATA"));
    const std::string colours = is_binary(form) ? std::string(cells, '\x80') + "\n"
                                                : numbers(form, std::vector<double>(cells, 0.5));
    text += fmt::format("CELL_DATA {}\nCOLOR_SCALARS material 1\n", cells) + colours +
            "FIELD FieldData 2\ntitle 1 2 string\n" + string_of(form, "a title") +
            string_of(form, "") + fmt::format("\nmean 1 {} double\n", cells) +
            numbers(form, std::vector<double>(cells, 7)) +
            fmt::format("POINT_DATA {}\nTENSORS6 stress double\n", points) +
            numbers(form, std::vector<double>(6 * points, 1)) +
            fmt::format("FIELD FieldData 1\nvelocity 3 {} double\n", points) +
            numbers(form, std::vector<double>(3 * points, 1)) +
            "METADATA\nCOMPONENT_NAMES\nu\n\nw\nINFORMATION 1\nNAME UNITS_LABEL LOCATION "
            "vtkDataArray\nDATA 1 m\n\n" +
            "SCALARS my%20temp%25 double 1\nLOOKUP_TABLE default\n" + numbers(form, of.values);
    const TempFolder folder;
    write_file(folder / "a.vtk", text);
    import::ImportOptions options;
    options.dataset = "my temp%";
    const auto opened = import::open_vtk_mesh(folder / "a.vtk", options, uint64_t{1} << 30);
    ASSERT_TRUE(opened) << opened.error().message;
    EXPECT_EQ(opened->mesh.values, of.values);
    options.dataset = "material";
    const auto material = import::open_vtk_mesh(folder / "a.vtk", options, uint64_t{1} << 30);
    ASSERT_TRUE(material) << material.error().message;
    EXPECT_NEAR(material->mesh.values.front(), is_binary(form) ? 128 : 0.5, 1e-9);
  }
}

TEST(CliLegacyMesh, FlatAndCompressedGridsHaveTheirOwnErrors) {
  const TempFolder folder;
  Lattice flat = lattice(true);
  flat.high[2] = 0;
  write_file(folder / "flat.vtk", legacy_text(Form::text_5, flat, true));
  const auto refused = run({"build", folder / "flat.vtk", "--no-thumbnail"});
  EXPECT_NE(refused.exit_code, 0);
  EXPECT_NE(refused.err.find("at least 2 voxels along each axis"), std::string::npos)
      << refused.err;
  EXPECT_EQ(refused.err.find("makes a scene"), std::string::npos) << refused.err;
  write_file(folder / "a.vtk.gz", test::deflated(legacy_text(Form::text_5, lattice(false), false)));
  const auto packed = run({"build", folder / "a.vtk.gz", "--no-thumbnail"});
  EXPECT_NE(packed.exit_code, 0);
  EXPECT_NE(packed.err.find("compressed as a whole"), std::string::npos) << packed.err;
}

/// The files of VTK's own writers, of old and new versions.
TEST(CliLegacyMesh, FilesOfVtkAreThoseOfItsXmlFiles) {
  const auto python = [](std::vector<std::string> arguments) {
    return run(test::Call{.arguments = std::move(arguments), .program = "/usr/bin/python3"});
  };
  if (python({"-c", "import vtk"}).exit_code != 0) GTEST_SKIP() << "needs python3-vtk9";
  const TempFolder folder;
  const auto written = python(
      {ISOSPLAT_SOURCE_DIR "/tests/native/write_meshes.py", folder.path().string(), "legacy"});
  ASSERT_EQ(written.exit_code, 0) << written.err;
  for (const char* kind : {"curved", "quadratic", "uneven"}) {
    const auto expected =
        import::open_vtk_mesh(folder / (kind + std::string(".xml")), {}, uint64_t{1} << 30);
    ASSERT_TRUE(expected) << expected.error().message;
    for (const char* form : {"42_text", "42_binary", "51_text", "51_binary"}) {
      SCOPED_TRACE(kind + std::string(form));
      const auto found = import::open_vtk_mesh(folder / fmt::format("{}_{}.vtk", kind, form), {},
                                               uint64_t{1} << 30);
      ASSERT_TRUE(found) << found.error().message;
      EXPECT_EQ(found->mesh.corners, expected->mesh.corners);
      ASSERT_EQ(found->mesh.points.size(), expected->mesh.points.size());
      ASSERT_EQ(found->mesh.values.size(), expected->mesh.values.size());
      for (size_t i = 0; i < found->mesh.points.size(); ++i) {
        EXPECT_LT(length(found->mesh.points[i] - expected->mesh.points[i]), 1e-5);
        EXPECT_NEAR(found->mesh.values[i], expected->mesh.values[i], 1e-5);
      }
    }
  }
}

TEST(CliLegacyMesh, RefusesMalformedFiles) {
  const TempFolder folder;
  const CellFile block = test::block_of(12, 1, nullptr, [](Vec3d p) { return p.x; });
  const std::string old = legacy_text(Form::text, block),
                    new_one = legacy_text(Form::text_5, block),
                    binary = legacy_text(Form::binary, block),
                    curved = legacy_text(Form::text, lattice(false), false),
                    uneven = legacy_text(Form::text, lattice(false), true);
  const struct {
    const std::string& text;
    std::string from, to, message;
  } cases[] = {
      {old, "POINTS 8", "POINTS 7", "expected"},
      {old, "POINTS 8", "POINTS 4000000000", "end of the file"},
      {binary, "POINTS 8", "POINTS 99999999999999999", "end of the file"},
      {old, "POINTS 8", "POINTS -8", "expected a number and a type after POINTS"},
      {old, "POINTS 8 double", "PINTS 8 double", "expected a section"},
      {old, "CELLS 1 9\n8 ", "CELLS 1 9\n9 ", "as the number of nodes of cell 0"},
      {old, "CELLS 1 9\n8 ", "CELLS 1 9\n-8 ", "found -8 as the number of nodes of cell 0"},
      {old, "CELLS 1 9\n8 ", "CELLS 1 9\n7 ", "expected 8 points of cell 0 of type 12, found 7"},
      {old, "CELLS 1 9\n8 0 ", "CELLS 1 9\n8 8 ", "found 8 in cell 0"},
      {old, "CELL_TYPES 1\n12 ", "CELL_TYPES 2\n12 12 ", "expected the nodes of 2 cells"},
      {old, "CELL_TYPES 1\n12 ", "CELL_TYPES 1\n42 ", "expected the faces of cell 0"},
      {old, "CELL_TYPES 1\n12 ", "CELL_TYPES 1\n41 ", "Tetrahedralize"},
      {old, "POINT_DATA 8", "POINT_DATA 7", "expected a section or the end of the file"},
      {new_one, "CELLS 2 8", "CELLS 3 8", "expected connectivity and a type after CELLS"},
      {new_one, "\n0 8 \n", "\n1 8 \n", "expected OFFSETS from 0 on, found 1"},
      {new_one, "\n0 8 \n", "\n0 9 \n", "expected 8 points of cell 0 of type 12, found 9"},
      {new_one, "OFFSETS", "OFFSET", "expected offsets and a type after CELLS"},
      {curved, "DIMENSIONS 5 4 3", "DIMENSIONS 5 4 4", "expected"},
      {curved, "DIMENSIONS 5 4 3", "DIMENSIONS 5 4 1", "expected a grid of three dimensions"},
      {curved, "DIMENSIONS 5 4 3", "DIMENSIONS 99999999999 4 3", "DIMENSIONS below"},
      {curved, "DIMENSIONS 5 4 3", "DIMENSIONS 2000000000 2000000000 3", "raise --memory"},
      {curved, "DIMENSIONS 5 4 3\n", "", "expected DIMENSIONS, found none"},
      {uneven, "X_COORDINATES", "W_COORDINATES", "found 'w_coordinates'"},
      {uneven, "0 1.125 ", "0 3.5 ", "that increase or decrease"},
  };
  for (const auto& each : cases) {
    std::string changed = each.text;
    const size_t at = changed.find(each.from);
    ASSERT_NE(at, changed.npos) << each.from;
    changed.replace(at, each.from.size(), each.to);
    write_file(folder / "a.vtk", changed);
    const auto ended = run({"build", folder / "a.vtk", "-o", folder / "b.isobundle"});
    EXPECT_EQ(ended.signal, 0) << each.to;
    EXPECT_NE(ended.exit_code, 0) << each.to;
    EXPECT_NE(ended.err.find(each.message), std::string::npos) << each.to << ": " << ended.err;
    EXPECT_FALSE(std::filesystem::exists(folder / "b.isobundle"));
  }
  // Every truncation is an error, except that of the line end after the last value.
  for (const std::string* text : {&binary, &new_one}) {
    for (size_t bytes = 60; bytes + 9 < text->size(); bytes += 13) {
      write_file(folder / "a.vtk", text->substr(0, bytes));
      EXPECT_FALSE(import::open_vtk_mesh(folder / "a.vtk", {}, uint64_t{1} << 30)) << bytes;
    }
  }
}

}  // namespace
}  // namespace isosplat
