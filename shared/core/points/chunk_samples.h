#pragma once

#include <span>
#include <vector>

#include "isosplat/points.h"
#include "shared/core/codec/chunk_codec.h"
#include "shared/core/grid/grid.h"
#include "shared/core/grid/region_mask.h"
#include "shared/core/points/lattice_gradients.h"

namespace isosplat {

/// The information that converts a chunk's cells to points of the world.
struct ChunkFrame {
  const VolumeGrid* grid;
  const ValueMapping* mapping;
  BlockKey block;
};

/// Where a point lies in its block.
struct PointPlace {
  uint32_t cell = 0;  ///< as DecodedCells::cell
  Vec3f in_cell;      ///< 0 to 1 along each axis; outside of it only with Displaced::drop
};

/// Unpacks the samples in these regions of their block. Corners have the precision of PackedSample.
/// Safe for any bytes.
DecodedCells cells_of(std::span<const PackedSample> samples, const RegionMask& regions);

/// The samples at the centres of cells, one entry per cell in each array.
SampleArrays samples_of(const DecodedCells& cells, const ChunkFrame& frame);

/// The projections of the active cells' samples onto the isosurface. `smooth_gradients` are the
/// sums over the cells around each lattice point of the block. If they are given, normals are
/// smooth. Otherwise, and where these sums are zero, a normal is the gradient of the trilinear
/// function of its cell. Appends to `places`, if it is given, where each point lies.
PointArrays project_samples(const DecodedCells& cells, const ChunkFrame& frame,
                            float quantized_isovalue, const ProjectionOptions& options,
                            const LatticeGradients* smooth_gradients = nullptr,
                            std::vector<PointPlace>* places = nullptr);

}  // namespace isosplat
