#pragma once

#include <fmt/format.h>

#include <array>
#include <functional>
#include <string>

#include "shared/core/base/vec3.h"

namespace isosplat::test {

/// A lattice of points: their places by their indices, and their values by their places. Cells have
/// the value of the field at the mean of their corners.
struct Lattice {
  std::array<int, 3> low{}, high{};  ///< the first and the last index along each axis
  std::function<Vec3d(Vec3d)> place = [](Vec3d index) { return index; };
  std::function<double(Vec3d)> field = [](Vec3d at) { return at.x; };
  std::string point_arrays{}, cell_arrays{};  ///< more arrays
};

inline std::string vtk_extent(const Lattice& of) {
  return fmt::format("{} {} {} {} {} {}", of.low[0], of.high[0], of.low[1], of.high[1], of.low[2],
                     of.high[2]);
}

/// Calls visit(index) for the points of a lattice, or for its cells if `more` is 0.
inline void for_each_index(const Lattice& of, int more, const std::function<void(Vec3d)>& visit) {
  for (int z = of.low[2]; z < of.high[2] + more; ++z) {
    for (int y = of.low[1]; y < of.high[1] + more; ++y) {
      for (int x = of.low[0]; x < of.high[0] + more; ++x) visit({1.0 * x, 1.0 * y, 1.0 * z});
    }
  }
}

inline std::string vtk_array(const char* type, const char* name, int components,
                             const std::string& text) {
  return fmt::format(
      "<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"ascii\">\n"
      "{}\n</DataArray>\n",
      type, name, components, text);
}

/// The values of the points and of the cells, as the arrays "density" and "mean".
inline std::string vtk_lattice_data(const Lattice& of) {
  std::string points, cells;
  for_each_index(of, 1, [&](Vec3d i) { points += fmt::format("{} ", of.field(of.place(i))); });
  for_each_index(of, 0, [&](Vec3d i) {
    Vec3d sum{0, 0, 0};
    for (int k = 0; k < 8; ++k)
      sum = sum + of.place(i + Vec3d{1. * (k & 1), k / 2 % 2 * 1., k / 4 * 1.});
    cells += fmt::format("{} ", of.field(sum * 0.125));
  });
  return "<PointData>" + vtk_array("Float64", "density", 1, points) + of.point_arrays +
         "</PointData>\n<CellData>" + vtk_array("Float64", "mean", 1, cells) + of.cell_arrays +
         "</CellData>\n";
}

inline std::string vtk_lattice_file(const Lattice& of, const std::string& type,
                                    const std::string& points) {
  const std::string extent = vtk_extent(of);
  return fmt::format(
      "<VTKFile type=\"{0}\" version=\"1.0\" byte_order=\"LittleEndian\">\n"
      "<{0} WholeExtent=\"{1}\">\n<Piece Extent=\"{1}\">\n{2}{3}</Piece>\n</{0}>\n</VTKFile>\n",
      type, extent, vtk_lattice_data(of), points);
}

/// A curvilinear lattice as the text of a .vts file.
inline std::string vts_text(const Lattice& of) {
  std::string positions;
  for_each_index(of, 1, [&](Vec3d i) {
    const Vec3d at = of.place(i);
    positions += fmt::format("{} {} {}\n", at.x, at.y, at.z);
  });
  return vtk_lattice_file(of, "StructuredGrid",
                          "<Points>" + vtk_array("Float64", "Points", 3, positions) + "</Points>");
}

/// A lattice whose places along an axis depend on the index along it, as the text of a .vtr file.
inline std::string vtr_text(const Lattice& of) {
  std::string arrays;
  for (size_t axis = 0; axis < 3; ++axis) {
    std::string along;
    for (int i = of.low[axis]; i <= of.high[axis]; ++i) {
      const Vec3d at = of.place({1. * i, 1. * i, 1. * i});
      along += fmt::format("{} ", axis == 0 ? at.x : axis == 1 ? at.y : at.z);
    }
    arrays += vtk_array("Float64", "", 1, along);
  }
  return vtk_lattice_file(of, "RectilinearGrid", "<Coordinates>" + arrays + "</Coordinates>");
}

}  // namespace isosplat::test
