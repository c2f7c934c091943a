#pragma once

#include <span>
#include <vector>

#include "shared/codec/chunk_codec.h"
#include "shared/grid/grid.h"
#include "shared/grid/region_mask.h"
#include "shared/sampling/projection.h"

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

/// Unpacks the samples that lie in these regions of their block. Corners are as near to the voxels
/// as packing leaves them (PackedSample); any bytes unpack to something.
DecodedCells cells_of(std::span<const PackedSample> samples, const RegionMask& regions);

SampleArrays samples_of(const DecodedCells& cells, const ChunkFrame& frame);

/// Points of an isosurface, with unit normals (towards smaller values; zero where the gradient is).
struct PointArrays {
  std::vector<Vec3d> positions;  ///< world
  std::vector<Vec3f> normals;
};

struct ProjectionOptions {
  /// Along the gradient's ray to the trilinear surface within the cell where it is met there
  /// (paper, section 3.1), otherwise, and without `exact`, by one Newton step (equations 5 and 6).
  bool exact = false;

  /// Of one Newton step. `clamp`: every active cell has exactly one point, inside of it, as the
  /// renderer draws it; at its centre where the gradient is zero. `drop`: at level 0 the paper's
  /// criterion, so there are fewer, some outside of their cell; those without a gradient have none.
  Displaced displaced = Displaced::clamp;
};

/// The projections of the active cells' samples onto the isosurface.
PointArrays project_samples(const DecodedCells& cells, const ChunkFrame& frame, float isocode,
                            const ProjectionOptions& options);

}  // namespace isosplat
