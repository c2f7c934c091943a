#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "shared/core/unstructured/mesh.h"

namespace isosplat {

/// A point on an isosurface in a cell of a mesh.
struct CellPoint {
  Vec3d position;
  Vec3d normal;     ///< of unit length, towards smaller values
  double size = 0;  ///< size_of() the cell
};

/// The point of a cell whose corners have values on both sides of the isovalue, or at it (min ≤
/// isovalue < max): the mean of the points where its edges have the isovalue, moved along the
/// gradient by Newton's method until the value differs from the isovalue by less than 10⁻⁹ of the
/// cell's range, but not out of the cell (Co, Hamann and Joy 2003, sections 3 and 7; from the
/// centre, the gradient often leads out of flat or slanted cells). Nothing for other cells, those
/// that are left out (UnstructuredMesh::size()), and where the gradient is 0.
std::optional<CellPoint> point_of_cell(const UnstructuredMesh& mesh, size_t cell, double isovalue);

}  // namespace isosplat
