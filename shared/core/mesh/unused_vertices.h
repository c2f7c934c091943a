#pragma once

#include "shared/core/mesh/mesh_part.h"

namespace isosplat {

/// Removes the vertices that belong to no triangle; the others keep their order. The mesh has only
/// this part.
void drop_unused_vertices(MeshPart& mesh);

}  // namespace isosplat
