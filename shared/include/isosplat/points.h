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

/// What becomes of a sample whose projection leads further than Δd.
enum class Displaced : uint8_t {
  clamp,  ///< it is moved that far and no further, and not out of its cell: closes all holes
  drop,   ///< it is left out (paper, section 3.2); coarse levels clamp nevertheless
};

/// Points of an isosurface, with unit normals (towards smaller values; zero where the gradient is).
struct PointArrays {
  std::vector<Vec3d> positions;  ///< world
  std::vector<Vec3f> normals;    ///< of the world; as many as positions
};

/// How a sample is projected onto the isosurface.
struct ProjectionOptions {
  /// Along the gradient's ray to the trilinear surface within the cell where it is met there
  /// (paper, section 3.1), otherwise, and without `exact`, by one Newton step (equations 5 and 6).
  bool exact = false;

  /// Of one Newton step. `clamp`: every active cell has exactly one point, inside of it, as the
  /// renderer draws it; at its centre where the gradient is zero. `drop`: at level 0 the paper's
  /// criterion, so there are fewer, some outside of their cell; those without a gradient have none.
  Displaced displaced = Displaced::clamp;
};

}  // namespace isosplat
