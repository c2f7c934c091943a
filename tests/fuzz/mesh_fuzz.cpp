// Meshes of VTK, in XML and in legacy files, and the headers of adaptive grids.
//
// If the first byte of the input is 128 or more, the rest is a file. Otherwise the byte is the
// number of a valid file (text or binary), and the rest are edits of it.
#include <sys/mman.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

#include "shared/core/unstructured/resample.h"
#include "shared/import/vtk_amr/hierarchy.h"
#include "shared/import/vtk_amr/vtk_amr.h"
#include "shared/import/vtk_mesh/vtk_mesh.h"
#include "tests/fuzz/edits.h"

namespace isosplat::import {
namespace {

constexpr uint64_t kMemory = uint64_t{1} << 20;

void require(bool condition) {
  if (!condition) std::abort();
}

std::string array(const char* type, const char* name, int components, const std::string& values) {
  return "<DataArray type=\"" + std::string(type) + "\" Name=\"" + name +
         "\" NumberOfComponents=\"" + std::to_string(components) + "\" format=\"ascii\">" + values +
         "</DataArray>\n";
}

std::string numbers(int from, int count) {
  std::string text;
  for (int i = 0; i < count; ++i) text += std::to_string(from + i) + " ";
  return text;
}

/// The points of a lattice of 3³, of which every second one is moved.
std::string positions() {
  std::string text;
  for (int i = 0; i < 27; ++i) {
    text += std::to_string(i % 3 + 0.1 * (i % 2)) + " " + std::to_string(i / 3 % 3) + " " +
            std::to_string(i / 9) + "\n";
  }
  return text;
}

/// A curvilinear or unevenly spaced lattice.
std::string lattice_file(bool is_curved) {
  const std::string type = is_curved ? "StructuredGrid" : "RectilinearGrid";
  const std::string places =
      is_curved ? "<Points>" + array("Float32", "Points", 3, positions()) + "</Points>"
                : "<Coordinates>" + array("Float64", "x", 1, "0 1 3") +
                      array("Float64", "y", 1, "2 1 -3") + array("Float64", "z", 1, "0 1 4") +
                      "</Coordinates>";
  return "<VTKFile type=\"" + type + "\" version=\"1.0\"><" + type +
         " WholeExtent=\"0 2 0 2 0 2\"><Piece Extent=\"0 2 0 2 0 2\"><PointData>" +
         array("Float32", "density", 1, numbers(0, 27)) +
         array("UInt8", "vtkGhostType", 1, numbers(0, 27)) + "</PointData><CellData>" +
         array("UInt8", "vtkGhostType", 1, "0 0 1 0 0 32 0 0") + "</CellData>" + places +
         "</Piece></" + type + "></VTKFile>";
}

/// A hexahedron, a wedge, a quadratic tetrahedron, a hexahedron as a polyhedron, and a line.
std::string cells_file() {
  const std::string nodes =
      "0 1 4 3 9 10 13 12 1 2 5 10 11 14 0 2 6 18 1 4 3 9 10 12 "
      "4 5 8 7 13 14 17 16 0 1 ";
  const std::string faces =
      "6 4 4 5 8 7 4 13 14 17 16 4 4 5 14 13 4 5 8 17 14 4 8 7 16 17 4 7 4 13 16";
  return "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\"><UnstructuredGrid>"
         "<Piece NumberOfPoints=\"27\" NumberOfCells=\"5\"><PointData>" +
         array("Float32", "density", 1, numbers(0, 27)) + "</PointData><CellData>" +
         array("Int32", "number", 1, numbers(0, 5)) +
         array("UInt8", "vtkGhostType", 1, "0 0 0 16 0") + "</CellData><Points>" +
         array("Float32", "Points", 3, positions()) + "</Points><Cells>" +
         array("Int64", "connectivity", 1, nodes) + array("Int64", "offsets", 1, "8 14 24 32 34") +
         array("UInt8", "types", 1, "12 13 24 42 3") + array("Int64", "faces", 1, faces) +
         array("Int64", "faceoffsets", 1, "-1 -1 -1 31 -1") +
         "</Cells></Piece></UnstructuredGrid></VTKFile>";
}

void add_big_endian(std::string& file, uint64_t value, int bytes) {
  for (int i = bytes - 1; i >= 0; --i) file.push_back(static_cast<char>(value >> (8 * i)));
}

/// Numbers in text form, or big-endian floats (4) or integers (4 or 8).
std::string values(const std::vector<double>& of, bool is_binary, bool are_floats, int bytes = 4) {
  std::string text;
  for (const double each : of) {
    if (!is_binary) {
      text += std::to_string(each) + " ";
      if (!are_floats) text.replace(text.rfind('.'), text.npos, " ");
    } else if (are_floats) {
      const auto number = static_cast<float>(each);
      uint32_t bits = 0;
      std::memcpy(&bits, &number, 4);
      add_big_endian(text, bits, 4);
    } else {
      add_big_endian(text, static_cast<uint64_t>(static_cast<int64_t>(each)), bytes);
    }
  }
  return text + "\n";
}

std::vector<double> points_of_lattice() {
  std::vector<double> all;
  for (int i = 0; i < 27; ++i)
    all.insert(all.end(), {i % 3 + 0.1 * (i % 2), i / 3 % 3 * 1.0, i / 9 * 1.0});
  return all;
}

std::string legacy_file(const std::string& dataset, bool is_binary, bool has_offsets) {
  std::string file = std::string("# vtk DataFile Version ") + (has_offsets ? "5.1" : "3.0") +
                     "\nmesh\n" + (is_binary ? "BINARY" : "ASCII") + "\nDATASET " + dataset + "\n";
  if (dataset != "UNSTRUCTURED_GRID") file += "DIMENSIONS 3 3 3\n";
  if (dataset == "RECTILINEAR_GRID") {
    for (const char axis : {'X', 'Y', 'Z'}) {
      file += std::string(1, axis) + "_COORDINATES 3 float\n" + values({0, 1, 3}, is_binary, true);
    }
  } else {
    file += "POINTS 27 float\n" + values(points_of_lattice(), is_binary, true);
  }
  int cells = 8;
  if (dataset == "UNSTRUCTURED_GRID") {
    cells = 2;
    if (has_offsets) {
      file += "CELLS 3 14\nOFFSETS vtktypeint64\n" + values({0, 8, 14}, is_binary, false, 8) +
              "CONNECTIVITY vtktypeint64\n" +
              values({0, 1, 4, 3, 9, 10, 13, 12, 1, 2, 5, 10, 11, 14}, is_binary, false, 8);
    } else {
      file += "CELLS 2 16\n" +
              values({8, 0, 1, 4, 3, 9, 10, 13, 12, 6, 1, 2, 5, 10, 11, 14}, is_binary, false);
    }
    file += "CELL_TYPES 2\n" + values({12, 13}, is_binary, false);
  }
  std::vector<double> of_points, of_cells;
  for (int i = 0; i < 27; ++i) of_points.push_back(i);
  for (int i = 0; i < cells; ++i) of_cells.push_back(i);
  return file + "CELL_DATA " + std::to_string(cells) + "\nFIELD f 1\nnumber 1 " +
         std::to_string(cells) + " int\n" + values(of_cells, is_binary, false) +
         "POINT_DATA 27\nSCALARS density float\nLOOKUP_TABLE default\n" +
         values(of_points, is_binary, true);
}

std::string hierarchy_file() {
  return "<VTKFile type=\"vtkOverlappingAMR\" version=\"1.1\">"
         "<vtkOverlappingAMR origin=\"0 0 0\" grid_description=\"XYZ\">"
         "<Block level=\"0\" spacing=\"1 1 1\"><DataSet index=\"0\" amr_box=\"0 7 0 7 0 7\" "
         "file=\"a/0.vti\"/></Block><Block level=\"1\" spacing=\"0.5 0.5 0.5\"><DataSet "
         "index=\"0\" "
         "amr_box=\"4 7 4 7 4 7\" file=\"a/1.vti\"/><DataSet index=\"1\" amr_box=\"8 9 4 7 4 7\"/>"
         "</Block></vtkOverlappingAMR></VTKFile>";
}

std::vector<std::string> make_files() {
  std::vector<std::string> files{lattice_file(true), lattice_file(false), cells_file(),
                                 hierarchy_file()};
  for (const bool is_binary : {false, true}) {
    files.push_back(legacy_file("STRUCTURED_GRID", is_binary, false));
    files.push_back(legacy_file("RECTILINEAR_GRID", is_binary, false));
    files.push_back(legacy_file("UNSTRUCTURED_GRID", is_binary, false));
    files.push_back(legacy_file("UNSTRUCTURED_GRID", is_binary, true));
  }
  return files;
}

/// Whether a mesh is as its declarations state.
void check(const UnstructuredMesh& mesh) {
  require(mesh.begins.size() == mesh.cells() && mesh.values.size() == mesh.points.size());
  for (size_t cell = 0; cell < mesh.cells(); ++cell) {
    require(mesh.begins[cell] + static_cast<size_t>(corner_count(mesh.shapes[cell])) <=
            mesh.corners.size());
    for (const uint32_t corner : mesh.corners_of(cell)) require(corner < mesh.points.size());
  }
}

bool read_file(const std::filesystem::path& path) {
  ImportOptions options;
  const auto head = read_head(path);
  if (!head) return false;
  if (is_vtk_amr(head->bytes())) {
    static_cast<void>(open_vtk_amr(path, options, kMemory));
    return read_vtk_hierarchy(path).has_value();
  }
  if (!is_vtk_mesh(*head)) return false;
  bool is_read = false;
  for (const char* dataset : {"", "number"}) {
    options.dataset = dataset;
    const auto opened = open_vtk_mesh(path, options, kMemory);
    if (!opened) continue;
    is_read = true;
    check(opened->mesh);
    if (opened->mesh.cells() > 100) continue;
    const auto resampled = resample(opened->mesh, {0, kMemory});
    if (resampled) require(measure_error(opened->mesh, *resampled).rms >= 0);
  }
  return is_read;
}

}  // namespace
}  // namespace isosplat::import

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace isosplat;
  using namespace isosplat::import;
  static const int memory = memfd_create("mesh", 0);
  static const std::string path = "/proc/self/fd/" + std::to_string(memory);
  const auto read = [](const std::string& file) {
    if (ftruncate(memory, 0) != 0) return false;
    if (pwrite(memory, file.data(), file.size(), 0) != static_cast<ssize_t>(file.size())) {
      return false;
    }
    return read_file(path);
  };
  static const std::vector<std::string> files = [&] {
    std::vector<std::string> all = make_files();
    for (const std::string& file : all) require(read(file));  // before they are edited
    return all;
  }();
  fuzz::Input input(data, size);
  const uint32_t which = input.number(1);
  std::string file;
  if (which >= 128) {
    const auto rest = input.rest();
    file.assign(reinterpret_cast<const char*>(rest.data()), rest.size());
  } else {
    file = files[which % files.size()];
    if (which & 64) file.resize(input.number(2) % file.size());
    fuzz::edit(std::as_writable_bytes(std::span(file)), input);
  }
  read(file);
  return 0;
}
