#pragma once

#include <optional>
#include <span>
#include <vector>

#include "shared/render/camera.h"
#include "shared/sampling/cell.h"

namespace isosplat {

/// The trilinear isosurface by casting a ray through each cell on the way, in double precision on
/// the CPU: the reference that pictures are judged by. Slow, exact to 10⁻⁶ of a cell.
class RayCaster {
 public:
  struct Hit {
    double depth = 0;     ///< distance from the eye's plane along the view, world units
    Vec3d normal;         ///< unit length, world; towards higher values
    double gradient = 0;  ///< its length, quantized values per world unit
  };

  /// `codes`: all voxels, x fastest; must outlive the caster. Missing voxels make cells inactive.
  RayCaster(const VolumeGrid& grid, std::span<const QuantizedValue> quantized_values,
            bool has_missing);

  /// The first hit through the centre of pixel (x, y), y up, of an image of this size.
  std::optional<Hit> cast(const Camera& camera, int width, int height, int x, int y,
                          double quantized_isovalue) const;

 private:
  std::optional<Hit> cast_ray(Vec3d origin, Vec3d direction, double quantized_isovalue) const;
  CellInterval cell_interval(Index3 cell) const;

  VolumeGrid grid_;
  Matrix3d dual_edges_;
  std::span<const QuantizedValue> quantized_values_;
  bool has_missing_;
  Index3 bricks_;
  std::vector<CellInterval> brick_;  // interval of 8³ cells each, to step over what is empty
};

}  // namespace isosplat
