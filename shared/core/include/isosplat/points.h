#pragma once

/// \file
/// Samples, and points of an isosurface: iso-splatting after Co, Hamann and Joy (2003), "the
/// paper".

#include <array>
#include <cstdint>
#include <vector>

#include "isosplat/geometry.h"

namespace isosplat {

/// The samples at the centres of cells, one entry per cell in each array.
struct SampleArrays {
  std::vector<Vec3f> positions;                 ///< world
  std::vector<float> values;                    ///< of the volume
  std::vector<Vec3f> gradients;                 ///< values per world unit
  std::vector<std::array<float, 2>> intervals;  ///< lowest and highest value of the cell
};

/// What happens to a sample that the Newton step would move further than Δd, half the longest
/// diagonal of its cell.
enum class Displaced : uint8_t {
  clamp,  ///< it is moved that far and no further, and not out of its cell: closes all holes
  drop,   ///< it is left out (paper, section 3.2); coarse levels clamp nevertheless
};

/// Points of an isosurface, with unit normals (towards smaller values; zero where the gradient is
/// zero).
struct PointArrays {
  std::vector<Vec3d> positions;  ///< world
  std::vector<Vec3f> normals;    ///< of the world; as many as positions
  /// The volume's values at the positions, by trilinear interpolation in the cell. They are near
  /// the isovalue. As many as positions, or none, depending on ProjectionOptions::values.
  std::vector<float> values;
};

/// How a sample is projected onto the isosurface.
struct ProjectionOptions {
  /// true: the sample moves along its gradient to the nearest intersection with the trilinear
  /// surface in the cell (paper, section 3.1). If the cell has no such intersection, or if false,
  /// it moves by one Newton step (equations 5 and 6).
  bool exact = false;

  /// Applies to the Newton step. `clamp`: every active cell has exactly one point, inside the cell
  /// (its centre if the gradient is zero), as the renderer draws it. `drop`: level 0 follows the
  /// paper: some cells have no point, and some points are outside their cell. A cell with a zero
  /// gradient has no point.
  Displaced displaced = Displaced::clamp;

  bool values = false;  ///< whether PointArrays::values are computed
};

}  // namespace isosplat
