#pragma once

#include <functional>

#include "native/extract/extract.h"
#include "shared/core/mesh/mesh_part.h"

namespace isosplat {

/// The isosurface of the store's trilinear function as triangles (shared/core/mesh). It is closed
/// and 2-manifold, except at the borders of the volume and of its missing voxels, and does not
/// depend on the number of threads. Calls `write` for layers of blocks, in ascending z, on the
/// calling thread; at most two layers are in memory. A vertex has the values of the fields'
/// trilinear functions (FieldLattice): on an edge of cells, those between the ends of this edge;
/// the vertices inside of ambiguous cells have those of the eight corners. Errors: those of
/// extract_samples and FieldReader, out_of_memory (more than 2³² − 1 vertices), and the first error
/// of `write`, which ends the extraction.
Result<MeshCounts> extract_mesh(const StoreFile& store, double isovalue,
                                const ExtractOptions& options,
                                const std::function<Result<void>(MeshPart&&)>& write);

}  // namespace isosplat
