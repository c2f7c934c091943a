#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "native/extract/field_reading.h"
#include "shared/core/mesh/cell_region.h"
#include "shared/core/mesh/mesh_part.h"
#include "shared/core/points/chunk_samples.h"
#include "shared/core/sampling/packed_sample.h"
#include "shared/system/store_file/store_file.h"

namespace isosplat {

struct ExtractOptions {
  uint32_t level = 0;
  unsigned threads = 0;                   ///< 0: one per core
  bool smooth_normals = true;             ///< of points; false: the gradient of each cell
  std::optional<CellRegion> region = {};  ///< only these cells are extracted
  std::optional<VolumeGrid> grid = {};    ///< where the volume lies, if not where its store says
  float least_distance = 0;               ///< of meshes: BlockMesher::keep_off_lattice_points
  OpenedFields fields = {};               ///< of the store, whose values are wanted as well
};

/// Where the volume of a store lies.
inline const VolumeGrid& grid_of(const StoreFile& store, const ExtractOptions& options) {
  return options.grid ? *options.grid : store.info().grid;
}

/// The samples of one chunk, in the GPU's layout.
struct ChunkSamples {
  ChunkRef chunk;
  std::vector<PackedSample> samples;
};

/// Decodes all chunks that an isovalue needs at one level, in file order: one chunk for each block
/// that the isosurface may cross. A chunk also has some inactive cells, which the vertex shader
/// discards. If any cell of a chunk may be in the region, all of its cells are returned. Replaces
/// the content of `result` and reuses its memory: pass the same vector for the next isovalue.
/// Errors: not_found (no such level), invalid_argument (the isovalue is not finite), out_of_memory
/// (the system refuses memory or threads), and those of StoreFile and ChunkDecoder; `result` is
/// then empty.
Result<void> extract_samples(const StoreFile& store, double isovalue, const ExtractOptions& options,
                             std::vector<ChunkSamples>& result);

/// Points on the isosurface with unit normals towards smaller values: one for each active cell,
/// unless `projection` drops some. Smooth normals are those of SmoothGradients, over all cells of
/// the chunks that the isovalue needs. Calls `write` for the points of each chunk, in raster order
/// of blocks, on the calling thread. Memory: a few chunks. Smooth normals need 4.4 MB more per
/// thread. They also need the sums at the borders of the blocks of three layers along z: 16 bytes
/// for each lattice point of a border that a cell touches. Returns the number of points. Errors:
/// those of extract_samples, those of FieldReader, and the first error of `write`, which ends the
/// extraction. Fields: of a point that Displaced::drop leaves outside of its cell, the values at
/// the nearest point of the cell.
Result<uint64_t> extract_points(const StoreFile& store, double isovalue,
                                const ProjectionOptions& projection, const ExtractOptions& options,
                                const std::function<Result<void>(PointsWithFields&&)>& write);

}  // namespace isosplat
