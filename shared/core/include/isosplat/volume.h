#pragma once

/// \file
/// The description of a volume, known before any voxel is read.

#include <cstdint>

#include "isosplat/geometry.h"

namespace isosplat {

/// A volume as its store describes it. A voxel's position in the world is
/// origin + direction · (spacing ∘ index) (∘ multiplies component by component), in the units of
/// the volume's header (millimetres for medical images, in LPS orientation); its value is
/// value_offset + value_scale · quantized value.
struct Volume {
  Index3 voxels;           ///< along each axis, each ≥ 2
  Vec3d spacing{1, 1, 1};  ///< distance between neighbours along each axis, each > 0
  Vec3d origin;            ///< the centre of voxel (0, 0, 0)
  /// Its columns are the axes, of unit length, not always perpendicular.
  Matrix3d direction = kIdentity3;
  double value_offset = 0;  ///< the value of quantized value 0
  double value_scale = 1;   ///< between neighbouring quantized values, > 0
  /// Largest difference between a stored value and the voxel's; 0: lossless.
  double max_error = 0;
  double min_value = 0;         ///< of all voxels that have a value
  double max_value = 0;         ///< isovalues in [min_value, max_value) have a surface
  uint64_t missing_voxels = 0;  ///< voxels without a value (NaN, fill values)
  uint32_t levels = 1;          ///< ≥ 1; level l halves each axis l times
};

}  // namespace isosplat
