#pragma once

#include "native/extract/extract_mesh.h"

namespace isosplat {

/// Removes vertices of a mesh as long as the surface stays within about `max_error` (> 0, in the
/// units of the positions), by edge collapses in the order of their quadric errors (M. Garland,
/// P. Heckbert, "Surface simplification using quadric error metrics", 1997; meshoptimizer). The
/// quadric error is the root mean square of the distances to the planes of the original triangles,
/// so single points may be farther away. Remaining vertices keep their positions and normals; the
/// topology of the surface remains. Returns the largest quadric error of a collapse. Needs about
/// 100 bytes of memory for each vertex. Errors: out_of_memory.
Result<double> simplify_mesh(MeshPart& mesh, double max_error);

}  // namespace isosplat
