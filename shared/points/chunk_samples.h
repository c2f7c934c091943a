#pragma once

#include <vector>

#include "shared/codec/chunk_codec.h"
#include "shared/grid/grid.h"

namespace isosplat {

/// What a chunk's cells need to become points of the world.
struct ChunkFrame {
  const VolumeGrid* grid;
  const ValueMapping* mapping;
  BlockKey block;
};

/// The samples at the centres of cells, one entry per cell in each array.
struct SampleArrays {
  std::vector<Vec3f> positions;                 ///< world
  std::vector<float> values;                    ///< of the volume
  std::vector<Vec3f> gradients;                 ///< values per world unit
  std::vector<std::array<float, 2>> intervals;  ///< lowest and highest value of the cell
};

SampleArrays samples_of(const DecodedCells& cells, const ChunkFrame& frame);

/// Points of an isosurface, with unit normals (towards smaller values; zero where the gradient is).
struct PointArrays {
  std::vector<Vec3d> positions;  ///< world
  std::vector<Vec3f> normals;
};

/// The projections of the active cells' samples. `exact`: along the gradient's ray to the trilinear
/// surface within the cell where it is met there (paper, section 3.1), otherwise, and without
/// `exact`, by one Newton step (equations 5 and 6). A sample that moves further than the
/// displacement threshold is dropped at level 0, and moved just so far at coarser levels, where the
/// cell's surface may lie outside of its corners' range.
PointArrays project_samples(const DecodedCells& cells, const ChunkFrame& frame, float isocode,
                            bool exact);

}  // namespace isosplat
