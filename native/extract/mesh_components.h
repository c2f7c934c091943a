#pragma once

#include <cstddef>

#include "native/extract/extract_mesh.h"

namespace isosplat {

/// Drops all but the `count` components of largest area, and the vertices that no triangle uses any
/// more. A component is a set of triangles that are connected by shared vertices. Of components of
/// equal area, the first one is kept. The order of vertices and triangles remains. Returns the
/// previous number of components.
size_t keep_largest_components(MeshPart& mesh, size_t count);

}  // namespace isosplat
