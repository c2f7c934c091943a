#pragma once

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include "shared/core/base/vec3.h"
#include "shared/core/unstructured/cell_shape.h"

namespace isosplat::test {

/// A cell by VTK's number of its type.
struct FileCell {
  int type = 0;
  std::vector<size_t> nodes;
  std::vector<std::vector<size_t>> faces{};  ///< of polyhedra
};

/// A mesh of any cells. The values of the points are the array "density", the numbers of the cells
/// the array "number".
struct CellFile {
  std::vector<Vec3d> points;
  std::vector<double> values;
  std::vector<FileCell> cells;
  std::string cell_flags{};  ///< vtkGhostType, if not empty
  bool has_tables = false;   ///< faces of polyhedra as VTK 9.4 writes them

  /// Tables of faces, the last one first.
  std::array<std::string, 4> tables() const {
    std::vector<std::vector<size_t>> all;
    std::string offsets, to_faces, ends, corners;
    size_t total = 0, used = 0, end = 0;
    for (const FileCell& cell : cells) total += cell.faces.size();
    for (const FileCell& cell : cells) {
      for (const auto& face : cell.faces) {
        to_faces += fmt::format("{} ", total - ++used);
        all.insert(all.begin(), face);
      }
      offsets += fmt::format("{} ", used);
    }
    for (const auto& face : all) {
      ends += fmt::format("{} ", end += face.size());
      corners += fmt::format("{} ", fmt::join(face, " "));
    }
    return {offsets, to_faces, ends, corners};
  }

  std::string text() const {
    std::string positions, densities, numbers, nodes, ends, types, faces, face_ends;
    for (const Vec3d at : points) positions += fmt::format("{} {} {} ", at.x, at.y, at.z);
    for (const double value : values) densities += fmt::format("{} ", value);
    size_t end = 0, face_end = 0;
    bool has_faces = false;
    for (size_t i = 0; i < cells.size(); ++i) {
      const FileCell& cell = cells[i];
      nodes += fmt::format("{} ", fmt::join(cell.nodes, " "));
      ends += fmt::format("{} ", end += cell.nodes.size());
      types += fmt::format("{} ", cell.type);
      numbers += fmt::format("{} ", i);
      if (cell.type == 42) {
        faces += fmt::format("{} ", cell.faces.size());
        ++face_end;
        for (const auto& face : cell.faces) {
          faces += fmt::format("{} {} ", face.size(), fmt::join(face, " "));
          face_end += face.size() + 1;
        }
        has_faces = true;
      }
      face_ends += cell.type == 42 ? fmt::format("{} ", face_end) : "-1 ";
    }
    const auto array = [](const char* type, const char* name, int components,
                          const std::string& text) {
      return fmt::format(
          "<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"ascii\">\n"
          "{}\n</DataArray>\n",
          type, name, components, text);
    };
    return fmt::format(
               "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\">\n"
               "<UnstructuredGrid>\n<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n",
               points.size(), cells.size()) +
           "<PointData>" + array("Float64", "density", 1, densities) + "</PointData>\n<CellData>" +
           array("Int32", "number", 1, numbers) +
           (cell_flags.empty() ? "" : array("UInt8", "vtkGhostType", 1, cell_flags)) +
           "</CellData>\n<Points>" + array("Float64", "Points", 3, positions) +
           "</Points>\n<Cells>" + array("Int64", "connectivity", 1, nodes) +
           array("Int64", "offsets", 1, ends) + array("UInt8", "types", 1, types) +
           (has_faces && has_tables ? array("Int64", "polyhedron_offsets", 1, tables()[0]) +
                                          array("Int64", "polyhedron_to_faces", 1, tables()[1]) +
                                          array("Int64", "face_offsets", 1, tables()[2]) +
                                          array("Int64", "face_connectivity", 1, tables()[3])
            : has_faces
                ? array("Int64", "faces", 1, faces) + array("Int64", "faceoffsets", 1, face_ends)
                : "") +
           "</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
  }
};

/// The corners whose mean is each further node of a type (vtkCellType.h).
inline std::vector<std::vector<size_t>> middles_of(int type) {
  const std::vector<std::vector<size_t>> of_hexahedron{{0, 1},
                                                       {1, 2},
                                                       {2, 3},
                                                       {3, 0},
                                                       {4, 5},
                                                       {5, 6},
                                                       {6, 7},
                                                       {7, 4},
                                                       {0, 4},
                                                       {1, 5},
                                                       {2, 6},
                                                       {3, 7},
                                                       {0, 3, 4, 7},
                                                       {1, 2, 5, 6},
                                                       {0, 1, 4, 5},
                                                       {2, 3, 6, 7},
                                                       {0, 1, 2, 3},
                                                       {4, 5, 6, 7},
                                                       {0, 1, 2, 3, 4, 5, 6, 7}};
  const std::vector<std::vector<size_t>> of_wedge{{0, 1}, {1, 2},       {2, 0},       {3, 4},
                                                  {4, 5}, {5, 3},       {0, 3},       {1, 4},
                                                  {2, 5}, {0, 1, 3, 4}, {1, 2, 4, 5}, {2, 0, 5, 3}};
  const auto first = [](const auto& all, std::ptrdiff_t count) {
    return std::vector<std::vector<size_t>>(all.begin(), all.begin() + count);
  };
  if (type == 24) return {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};
  if (type == 27) return {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {0, 4}, {1, 4}, {2, 4}, {3, 4}};
  if (type == 25 || type == 29 || type == 33) {
    return first(of_hexahedron, type == 25 ? 12 : type == 29 ? 19 : 16);
  }
  if (type == 26 || type == 31 || type == 32) {
    return first(of_wedge, type == 26 ? 9 : type == 31 ? 6 : 12);
  }
  return {};
}

/// The unit cube in count³ boxes, each divided into cells of a type: 12, 24 to 27, 29, 31 to 33.
/// `place` moves the nodes; null: they stay.
inline CellFile block_of(int type, int count, Vec3d (*place)(Vec3d),
                         const std::function<double(Vec3d)>& field) {
  CellFile of;
  std::map<std::array<int, 3>, size_t> known;
  const auto node = [&](Vec3d at) {
    const auto key = [](double x) { return static_cast<int>(std::lround(x * 960)); };
    const auto [found, is_new] =
        known.try_emplace({key(at.x), key(at.y), key(at.z)}, of.points.size());
    if (is_new) {
      of.points.push_back(place ? place(at) : at);
      of.values.push_back(field(of.points.back()));
    }
    return found->second;
  };
  using Corners = std::vector<size_t>;
  std::vector<Corners> cells{{0, 1, 2, 3, 4, 5, 6, 7}};  // corners of the box; 8: its centre
  if (type == 24) {
    cells.clear();
    for (const auto& [a, b] : {std::pair{1, 2}, {2, 3}, {3, 7}, {7, 4}, {4, 5}, {5, 1}}) {
      cells.push_back({0, static_cast<size_t>(a), static_cast<size_t>(b), 6});
    }
  } else if (type == 26 || type == 31 || type == 32) {
    cells = {{0, 1, 2, 4, 5, 6}, {0, 2, 3, 4, 6, 7}};
  } else if (type == 27) {
    cells.clear();
    for (const CellFace& face : faces_of(CellShape::hexahedron)) {
      Corners corners;
      for (const int8_t corner : face) corners.push_back(static_cast<size_t>(corner));
      corners.push_back(8);
      cells.push_back(corners);
    }
  }
  constexpr int kUnit[9][3] = {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}, {0, 0, 2},
                               {2, 0, 2}, {2, 2, 2}, {0, 2, 2}, {1, 1, 1}};
  for (int box = 0; box < count * count * count; ++box) {
    const Vec3d low{1. * (box % count), 1. * (box / count % count), 1. * (box / count / count)};
    for (const Corners& corners : cells) {
      std::vector<Vec3d> at;
      for (const size_t i : corners) {
        const auto& unit = kUnit[i];
        at.push_back((low + Vec3d{unit[0] / 2., unit[1] / 2., unit[2] / 2.}) * (1. / count));
      }
      for (const auto& middle : middles_of(type)) {
        Vec3d sum{0, 0, 0};
        for (const size_t i : middle) sum = sum + at[i];
        at.push_back(sum * (1. / static_cast<double>(middle.size())));
      }
      FileCell cell{type, {}};
      for (const Vec3d each : at) cell.nodes.push_back(node(each));
      of.cells.push_back(cell);
    }
  }
  return of;
}

/// Turns a hexahedron into the polyhedron with its faces.
inline void make_polyhedron(FileCell& cell) {
  cell.type = 42;
  for (const CellFace& face : faces_of(CellShape::hexahedron)) {
    auto& corners = cell.faces.emplace_back();
    for (const int8_t corner : face) corners.push_back(cell.nodes[static_cast<size_t>(corner)]);
  }
}

/// Two prisms of a height of 1 above each other, as prisms or as polyhedra.
inline CellFile stacked_prisms(size_t sides, bool are_polyhedra,
                               const std::function<double(Vec3d)>& field) {
  CellFile of;
  for (size_t level = 0; level < 3; ++level) {
    for (size_t i = 0; i < sides; ++i) {
      const double angle =
          2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(sides);
      of.points.push_back({std::cos(angle), std::sin(angle), static_cast<double>(level)});
      of.values.push_back(field(of.points.back()));
    }
  }
  for (size_t level = 0; level < 2; ++level) {
    FileCell cell{are_polyhedra ? 42 : sides == 5 ? 15 : 16, {}};
    for (size_t i = 0; i < 2 * sides; ++i) cell.nodes.push_back(level * sides + i);
    const auto at = [&](size_t i) { return cell.nodes[i]; };
    cell.faces.resize(2);
    for (size_t i = 0; i < sides; ++i) {
      cell.faces[0].push_back(at(i));
      cell.faces[1].push_back(at(sides + i));
    }
    for (size_t i = 0; i < sides; ++i) {
      const size_t next = (i + 1) % sides;
      cell.faces.push_back({at(i), at(next), at(sides + next), at(sides + i)});
    }
    of.cells.push_back(cell);
  }
  return of;
}

}  // namespace isosplat::test
