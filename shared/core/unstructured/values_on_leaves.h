#pragma once

#include "shared/core/adaptive/adaptive_grid.h"
#include "shared/core/grid/grid.h"
#include "shared/core/unstructured/mesh.h"

namespace isosplat {

/// Brings the values of a mesh to the leaf cells of an adaptive grid, usually that of the same mesh
/// with other values (ResampledMesh). Corners of leaf cells have the values of the mesh there, or
/// border_values(). A leaf cell that is inside of the mesh to less than half becomes a hole.
/// `level_0`: as that of ResampledMesh. `memory_bytes`: limit, without the mesh. The result is
/// resolved. Errors: out_of_memory; malformed_volume if no cell of the mesh has values or a volume.
Result<AdaptiveGrid> values_on_leaves(const UnstructuredMesh& mesh, const AdaptiveGrid& grid,
                                      const VolumeGrid& level_0, uint64_t memory_bytes);

}  // namespace isosplat
