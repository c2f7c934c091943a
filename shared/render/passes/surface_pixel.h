#pragma once

#include <cstdint>

#include "shared/core/base/vec3.h"

namespace isosplat::render {

/// The surface at a pixel of the last draw, for tests and for picking. y points up, as in OpenGL.
struct SurfacePixel {
  bool hit = false;
  float depth = 0;          ///< distance from the eye's plane along the view, world units
  Vec3f normal;             ///< in the camera's frame (right, up, towards the eye), unit length
  uint32_t isosurface = 0;  ///< index in RenderSettings::isosurfaces
  bool cap = false;         ///< a face of the clipping (RenderSettings::clip_caps)
  /// Whether a slice is shown there: one of its values, or its pattern where there are none.
  /// `isosurface` is 0 then.
  enum class Slice : uint8_t { none, values, no_data } slice = Slice::none;
  float scalar = 0;  ///< position in the colour map, 0 … 1; of slices: by value; of
                     ///< categories: the index of the colour
  /// With ColourBy::field, unless it is a cap or a slice: whether the field has a value there,
  /// which `scalar` shows. none: the chunk has no values, or the volume no field.
  enum class Field : uint8_t { none, missing, value } field = Field::none;
};

}  // namespace isosplat::render
