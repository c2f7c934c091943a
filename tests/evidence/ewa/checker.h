#pragma once

#include <optional>

#include "tests/evidence/ewa/signal.h"

namespace isosplat {

/// A plane z = constant with a checker pattern, as a volume: f = isovalue + g (z − middle), where g
/// at the lattice points has two values by squares. Its isosurface is exactly the plane, and the
/// length of the gradient on it is g, interpolated bilinearly. So the colour by gradient shows the
/// pattern, and each sample has a colour. The pattern's edges are one cell wide.
struct Checker {
  static constexpr double kIsovalue = 1000, kLow = 100, kHigh = 400;  ///< values of g
  TestVolume volume;
  int square = 1;  ///< side, in cells

  /// `cells`: along x and y.
  Checker(int cells, int square_cells);

  /// The z of the plane, in the world.
  double plane() const { return 1.5; }
  /// Settings whose colour shows the pattern, without edge shading, occlusion or shadows.
  render::RenderSettings settings() const;
  Signal signal(const render::Camera& camera) const;

  /// The point at which the ray through a position in the image (px from its upper left corner)
  /// meets the plane.
  std::optional<Vec3d> point_at(const ImagePlane& image, Vec2d place) const;
  /// Whether the pattern covers everything within `margin` cells of a point.
  bool holds(Vec3d point, double margin) const;

  /// The frequency in the image, in cycles per px, of the wave of the pattern's spectrum with `m`
  /// and `n` cycles per two squares along x and y. The spectrum has odd m and n only.
  Vec2d frequency(const ImagePlane& image, Vec3d point, int m, int n) const;
  /// The phase of this wave at a point, in cycles.
  double phase(Vec3d point, int m, int n) const;
};

}  // namespace isosplat
