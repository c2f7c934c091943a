#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "shared/core/base/vec3.h"

namespace isosplat {

/// The shape of a linear cell. Its corners are in VTK's order (VTK User's Guide, "Cell types").
enum class CellShape : uint8_t { tetrahedron, pyramid, wedge, hexahedron };

inline constexpr int32_t kMostCorners = 8;

constexpr int32_t corner_count(CellShape shape) {
  constexpr int32_t kCounts[] = {4, 5, 6, 8};
  return kCounts[static_cast<size_t>(shape)];
}

/// The corners of a face, in order around it, as indices of the cell's corners; −1 after the third
/// one of a triangle.
using CellFace = std::array<int8_t, 4>;
std::span<const CellFace> faces_of(CellShape shape);

/// A cell with the positions of its corners.
struct CellGeometry {
  CellShape shape = CellShape::tetrahedron;
  std::array<Vec3d, kMostCorners> corners;

  int32_t count() const { return corner_count(shape); }
};

/// The weights of a cell's corners at a point: their sum is 1, and the weighted sum of the corners
/// is the point. Those of other corners are 0.
using CornerWeights = std::array<double, kMostCorners>;

/// How far outside of a cell a point may be and still count as inside, in coordinates of the cell,
/// which are from 0 to 1.
inline constexpr double kInsideTolerance = 1e-6;

/// The weights at a position, and their derivatives by the coordinates of the cell.
struct ShapeFunctions {
  CornerWeights at{};
  std::array<Vec3d, kMostCorners> slopes{};
};

/// The shape functions at a position in coordinates of the cell. Tetrahedra: the weights of corners
/// 1 to 3. Hexahedra: along the edges 0–1, 0–3 and 0–4. Wedges: along 0–1, 0–2 and 0–3. Pyramids:
/// (r (1 − t), s (1 − t), 1 − t) with VTK's coordinates r, s, t; with these, the mapping is regular
/// at the apex too.
ShapeFunctions shape_functions(CellShape shape, Vec3d at);
CornerWeights shape_weights(CellShape shape, Vec3d at);

/// Whether a position in coordinates of the cell is inside, with kInsideTolerance.
bool is_in_shape(CellShape shape, Vec3d at);

/// A corner in coordinates of the cell.
Vec3d shape_corner(CellShape shape, size_t corner);

/// The weights at a point, or nothing if the point is outside. Tetrahedra: in closed form. Other
/// cells: by Newton's method from the centre, until the last step is below 10⁻¹⁰ (cells whose
/// mapping folds over may have no solution; then the point is outside).
std::optional<CornerWeights> weights_in_cell(const CellGeometry& cell, Vec3d point);

/// The same for the corners of a tetrahedron.
std::optional<CornerWeights> weights_in_tetrahedron(const std::array<Vec3d, 4>& corners,
                                                    Vec3d point);

/// The volume that the faces enclose, ≥ 0.
double volume_of(const CellGeometry& cell);

/// The length by which grid cells are compared with a cell: the cube root of the volume of the
/// parallelepiped with the same edges, but at least a quarter of the longest edge. Flat cells
/// (slivers) would otherwise ask for grid cells much smaller than the detail of the mesh.
double size_of(const CellGeometry& cell);

}  // namespace isosplat
