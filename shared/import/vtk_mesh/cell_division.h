#pragma once

#include <array>
#include <span>

#include "shared/import/vtk_mesh/mesh_builder.h"

namespace isosplat::import {

/// A linear cell that is a part of a cell: its corners as numbers of the cell's nodes, which are
/// followed by the points that are added.
struct CellPart {
  CellShape shape = CellShape::tetrahedron;
  std::array<int8_t, kMostCorners> corners{};
};

/// The nodes around a point that is added (MeshBuilder::add_point).
struct CellPoint {
  std::array<int8_t, 8> corners{};
  std::array<int8_t, 12> middles{};
  size_t corner_count = 0, middle_count = 0;
};

/// How cells of a type are divided into linear ones.
///
/// Quadratic cells are divided into linear cells on their nodes, with half the edges: tetrahedra
/// into 8, hexahedra into 8, wedges into 8 and pyramids into 10. Faces of 8 nodes get a point in
/// their middle, by their shape functions. So a face depends on its own nodes alone, and neighbours
/// share it, whatever their types are.
struct CellDivision {
  size_t nodes = 0;
  std::span<const CellPoint> points;
  std::span<const CellPart> parts;
};

/// The division of cells of a number of VTK (vtkCellType.h): 10 to 14, which are linear, 24 to 27,
/// 29, and 31 to 33, which are quadratic. Null for other types.
const CellDivision* division_of(int type);

/// The most parts of a cell.
inline constexpr size_t kMostParts = 10;

/// Adds the parts of a cell. `nodes`: indices of points, as many as the division has. The
/// octahedron in a quadratic tetrahedron is divided along its shortest diagonal. Returns the number
/// of parts.
size_t add_divided(MeshBuilder& builder, int type, std::span<const uint32_t> nodes);

}  // namespace isosplat::import
