#pragma once

#include <cstdint>
#include <optional>

#include "shared/core/base/vec3.h"

namespace isosplat::render {

/// A point of a surface: where a ray meets the trilinear function of a cell.
struct SurfacePick {
  Vec3d position;           ///< world
  Vec3d voxel;              ///< the same in voxels of level 0
  Vec3d normal;             ///< world, unit length, towards the eye
  double gradient = 0;      ///< length of the gradient, value units per world unit
  double to_next = 0;       ///< along the ray to the next surface behind it, world units; 0: none
  uint32_t isosurface = 0;  ///< index in RenderSettings::isosurfaces
  uint32_t level = 0;       ///< of the cell: at 0 the pick is exact
  /// On a cap (RenderSettings::clip_caps) of the isosurface. Only a lower bound of the value there
  /// is known: the isovalue. The gradient is 0.
  bool cap = false;
  /// In a slice (RenderSettings::slices), whose value is `value`. The gradient and to_next are 0.
  bool slice = false;
  double value = 0;  ///< of the volume there; on a surface, its isovalue
  /// The value of the volume's field on a surface, NaN where it is missing. Nothing if the volume
  /// has no field, or its values are not on the GPU.
  std::optional<double> field = {};
};

}  // namespace isosplat::render
