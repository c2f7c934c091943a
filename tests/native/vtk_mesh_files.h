#pragma once

#include <fmt/format.h>

#include <string>

#include "tests/shared/mesh_fixture.h"

namespace isosplat::test {

/// VTK's number of a cell type.
inline int vtk_type(CellShape shape) {
  constexpr int kTypes[] = {10, 14, 13, 12};
  return kTypes[static_cast<size_t>(shape)];
}

/// A mesh as the text of a .vtu file: the values as the array "density" of the points, the numbers
/// of the cells as the array "number" of the cells, and the positions as the array "where".
inline std::string vtu_text(const UnstructuredMesh& mesh) {
  std::string positions, values, numbers, corners, offsets, types;
  for (size_t i = 0; i < mesh.points.size(); ++i) {
    const Vec3d at = mesh.points[i];
    positions += fmt::format("{} {} {}\n", at.x, at.y, at.z);
    values += fmt::format("{}\n", mesh.values[i]);
  }
  size_t end = 0;
  for (size_t cell = 0; cell < mesh.cells(); ++cell) {
    const auto of_cell = mesh.corners_of(cell);
    for (const uint32_t corner : of_cell) corners += fmt::format("{} ", corner);
    offsets += fmt::format("{}\n", end += of_cell.size());
    types += fmt::format("{}\n", vtk_type(mesh.shapes[cell]));
    numbers += fmt::format("{}\n", cell);
  }
  const auto array = [](const char* type, const char* name, int components,
                        const std::string& text) {
    return fmt::format(
        "<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"ascii\">\n"
        "{}</DataArray>\n",
        type, name, components, text);
  };
  return fmt::format(
             "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\">\n"
             "<UnstructuredGrid>\n<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n",
             mesh.points.size(), mesh.cells()) +
         "<PointData>" + array("Float64", "density", 1, values) +
         array("Float64", "where", 3, positions) + "</PointData>\n<CellData>" +
         array("Int32", "number", 1, numbers) + "</CellData>\n<Points>" +
         array("Float64", "Points", 3, positions) + "</Points>\n<Cells>" +
         array("Int64", "connectivity", 1, corners) + array("Int64", "offsets", 1, offsets) +
         array("UInt8", "types", 1, types) +
         "</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
}

}  // namespace isosplat::test
