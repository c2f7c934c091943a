#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "isosplat/geometry.h"
#include "shared/core/grid/grid.h"
#include "shared/core/sampling/cell.h"

namespace isosplat {

/// The values of a field at the lattice points of a block, and their trilinear interpolation.
/// Needs 550 KB.
class FieldLattice {
 public:
  /// `is_category`: instead of interpolating, points have the value of the nearest corner of their
  /// cell, edge or face; NaN where that is missing.
  explicit FieldLattice(const ValueMapping& mapping, bool is_category = false);

  /// Sets the values at the corners of these cells (ChunkDecoder::decode_field). Others remain.
  void set(std::span<const uint32_t> cells, std::span<const CellCorners> corners);

  /// The value at a point of a cell, 0 to 1 along each axis; of a point outside, the value at the
  /// nearest point of the cell. NaN where a corner of the cell is missing. The cell must be set.
  float at(uint32_t cell, Vec3f in_cell) const;

  /// The value at a point, in cells from the block's low corner. On an edge or a face of cells,
  /// only the ends of the edge, or the corners of the face, matter: NaN where one of them is
  /// missing. A cell that contains the point must be set.
  float at(Vec3f position) const;

 private:
  float interpolate(Index3 low, Vec3d t, bool needs_all) const;

  ValueMapping mapping_;
  bool is_category_;
  std::vector<QuantizedValue> values_;
};

}  // namespace isosplat
