#pragma once

#include "shared/core/base/vec3.h"

namespace isosplat::render {

/// A vertex of an indexed triangle mesh, which the renderer draws for comparison.
struct MeshVertex {
  Vec3f position;  ///< world, relative to the volume's centre (bounding_sphere(grid).centre)
  Vec3f normal;    ///< need not be of unit length
};

}  // namespace isosplat::render
