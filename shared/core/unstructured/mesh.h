#pragma once

#include <span>
#include <vector>

#include "shared/core/base/status.h"
#include "shared/core/unstructured/cell_shape.h"

namespace isosplat {

/// A box that is parallel to the axes.
struct Box {
  Vec3d low, high;

  bool overlaps(const Box& other) const {
    return low.x <= other.high.x && low.y <= other.high.y && low.z <= other.high.z &&
           other.low.x <= high.x && other.low.y <= high.y && other.low.z <= high.z;
  }
  bool contains(Vec3d p) const {
    return p.x >= low.x && p.y >= low.y && p.z >= low.z && p.x <= high.x && p.y <= high.y &&
           p.z <= high.z;
  }
  void add(Vec3d p);
};

/// Cells of any shapes, which share points, with a value at each point. A cell with a value that is
/// not finite is no part of the mesh.
struct UnstructuredMesh {
  std::vector<Vec3d> points;
  std::vector<double> values;     ///< one for each point
  std::vector<CellShape> shapes;  ///< one for each cell
  std::vector<uint32_t> begins;   ///< one for each cell: its first corner in `corners`
  std::vector<uint32_t> corners;  ///< indices of points, cell after cell

  size_t cells() const { return shapes.size(); }
  std::span<const uint32_t> corners_of(size_t cell) const {
    return std::span(corners).subspan(begins[cell],
                                      static_cast<size_t>(corner_count(shapes[cell])));
  }
  CellGeometry geometry(size_t cell) const;
  Box box(size_t cell) const;  ///< box_of() a cell
  bool has_values(size_t cell) const;
  /// size_of() a cell; 0 for those that are left out: without values, without a volume, or so large
  /// or small that their size is no float.
  float size(size_t cell) const;
  /// The weighted sum of the values at a cell's corners.
  double value(size_t cell, const CornerWeights& weights) const;
  uint64_t memory_bytes() const;
};

/// The bounding box of a cell.
Box box_of(const CellGeometry& cell);

/// For each point, the first point at the same position: those that differ by rounding, by about
/// 10⁻⁹ of the largest extent, count as the same.
inline constexpr double kPositionsPerExtent = 1e9;
std::vector<uint32_t> first_at_position(const std::vector<Vec3d>& points);

/// Values at points, of values that belong to cells: the average of the cells around a point,
/// weighted by their volumes. Points at the same position have the same value, so that blocks and
/// pieces with points of their own join. Points without a cell have NaN. `cell_values`: one for
/// each cell; a cell whose value is not finite is left out.
std::vector<double> values_at_points(const UnstructuredMesh& mesh,
                                     std::span<const double> cell_values);

}  // namespace isosplat
