#pragma once

#include <vector>

#include "shared/core/unstructured/cell_bins.h"

namespace isosplat {

/// Boxes of grid cells are larger by this share for cells of the mesh, and smaller for its border,
/// so that cells that only touch the border are inside.
inline constexpr double kBoxMargin = 1e-5;

/// The cells of a mesh near a grid cell, prepared for many searches.
class NearCells {
 public:
  explicit NearCells(const UnstructuredMesh& mesh) : mesh_(mesh) {}

  /// `cells`: in ascending order.
  void assign(std::span<const uint32_t> cells);

  size_t size() const { return cells_.size(); }
  uint32_t cell(uint32_t number) const { return cells_[number].cell; }
  const Box& box(uint32_t number) const { return cells_[number].box; }  ///< with a margin

  /// The first of some cells around a point, and the value there. `numbers`: of near cells.
  /// Nothing outside of them.
  std::optional<Located> find(std::span<const uint32_t> numbers, Vec3d point) const;

  /// The memory that the cells need, in bytes.
  static uint64_t bytes(size_t cells) { return cells * sizeof(Cell); }

 private:
  struct Cell {
    Box box;
    uint32_t cell = 0;
    bool has_weights = false;
    /// With has_weights: the weights of the corners 1 to 3 of a tetrahedron are the products of
    /// these vectors with the position relative to corner 0, but for rounding.
    Vec3d first, weights[3];
  };
  std::optional<CornerWeights> weights(size_t cell, Vec3d point) const;

  const UnstructuredMesh& mesh_;
  std::vector<Cell> cells_;
};

/// The box of a cell with a margin.
Box wide_box(const UnstructuredMesh& mesh, size_t cell);

}  // namespace isosplat
