#pragma once

#include <optional>
#include <span>
#include <vector>

#include "shared/core/sampling/cell.h"
#include "shared/render/settings/camera.h"

namespace isosplat {

/// Intersects rays with the trilinear isosurface, cell by cell along each ray, in double precision
/// on the CPU. Its results are the reference with which pictures are compared. It is slow, and
/// exact to 10⁻⁶ of a cell.
class RayCaster {
 public:
  struct Hit {
    double depth = 0;     ///< along the viewing direction, from the plane of the eye; world units
    Vec3d normal;         ///< unit length, world; towards higher values
    double gradient = 0;  ///< length of the gradient, quantized values per world unit
  };

  /// `quantized_values`: all voxels, x fastest; must outlive the ray caster. `has_missing`: cells
  /// with kMissingVoxel are inactive.
  RayCaster(const VolumeGrid& grid, std::span<const QuantizedValue> quantized_values,
            bool has_missing);

  /// The first intersection of the ray through the centre of pixel (x, y), y upwards, of an image
  /// of this size.
  std::optional<Hit> cast(const render::Camera& camera, int width, int height, int x, int y,
                          double quantized_isovalue) const;

 private:
  std::optional<Hit> cast_ray(Vec3d origin, Vec3d direction, double quantized_isovalue) const;
  /// The first intersection in a cell between the ray parameters `t` and `leave`.
  std::optional<Hit> intersect_cell(Index3 cell, Vec3d origin, Vec3d direction, double t,
                                    double leave, double quantized_isovalue) const;
  CellInterval cell_interval(Index3 cell) const;

  VolumeGrid grid_;
  Matrix3d dual_edges_;
  std::span<const QuantizedValue> quantized_values_;
  bool has_missing_;
  Index3 bricks_;
  std::vector<CellInterval> brick_;  // intervals of 8³ cells each, to skip empty space
};

}  // namespace isosplat
