#pragma once

#include <span>

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

/// Unpacks the samples in these regions of their block. Corners have the precision of PackedSample.
/// Safe for any bytes.
DecodedCells cells_of(std::span<const PackedSample> samples, const RegionMask& regions);

/// The samples at the centres of cells, one entry per cell in each array.
SampleArrays samples_of(const DecodedCells& cells, const ChunkFrame& frame);

/// The projections of the active cells' samples onto the isosurface. Normals are smooth if
/// `smooth_gradients` is given: the sums of the cells around the block's lattice points. Otherwise,
/// and where these sums are zero, they are the gradients of each cell's own trilinear function.
PointArrays project_samples(const DecodedCells& cells, const ChunkFrame& frame,
                            float quantized_isovalue, const ProjectionOptions& options,
                            const LatticeGradients* smooth_gradients = nullptr);

}  // namespace isosplat
