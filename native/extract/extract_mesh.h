#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "native/extract/extract.h"

namespace isosplat {

/// A part of a mesh. Vertices are numbered over all parts, from 0 in the order in which they are
/// written; triangles refer to vertices of this part and of earlier ones.
struct MeshPart {
  PointArrays vertices;
  std::vector<std::array<uint32_t, 3>> triangles;  ///< counter-clockwise seen from smaller values
};

struct MeshCounts {
  uint64_t vertices = 0, triangles = 0;
};

/// The isosurface of the store's trilinear function as triangles (shared/mesh): closed and
/// 2-manifold except where the volume or its missing voxels end, the same for any number of
/// threads. Calls `write` for layers of blocks, in ascending z, on the calling thread; at most two
/// layers are in memory. Errors: as extract_samples, out_of_memory (more than 2³² − 1 vertices),
/// and the first error of `write`, which ends the extraction.
Result<MeshCounts> extract_mesh(const StoreFile& store, double isovalue,
                                const ExtractOptions& options,
                                const std::function<Result<void>(MeshPart&&)>& write);

}  // namespace isosplat
