#pragma once

#include <optional>

#include "shared/render/settings/camera.h"

namespace isosplat {

/// A sample of a surface with its reconstruction kernel: a Gaussian in the tangent plane (M.
/// Zwicker, H. Pfister, J. van Baar, M. Gross, "Surface Splatting", SIGGRAPH 2001).
struct Surfel {
  Vec3d position;        ///< world
  Vec3d normal;          ///< world, unit length
  double area = 1;       ///< of the surface that it represents, world units²
  double deviation = 1;  ///< standard deviation of the kernel in the tangent plane, world units
  Vec3f colour;          ///< linear
};

/// A vector of the image, in px: to the right and down.
struct Vec2d {
  double x = 0, y = 0;
};

/// A symmetric 2 × 2 matrix: the variance of a Gaussian in the image, px².
struct Variance2 {
  double xx = 1, xy = 0, yy = 1;

  double determinant() const { return xx * yy - xy * xy; }
  /// vᵀ V⁻¹ v.
  double inverse_form(Vec2d v) const {
    return (v.x * v.x * yy - 2 * v.x * v.y * xy + v.y * v.y * xx) / determinant();
  }
  /// vᵀ V v.
  double form(Vec2d v) const { return v.x * v.x * xx + 2 * v.x * v.y * xy + v.y * v.y * yy; }
};

/// Maps points of the world to positions in an image, and gives the derivatives.
class ImagePlane {
 public:
  ImagePlane(const render::Camera& camera, int width, int height);

  const render::CameraFrame& frame() const { return frame_; }
  int width() const { return width_; }
  int height() const { return height_; }

  /// Distance of a point from the eye along the view. With a perspective camera, the functions
  /// below require that it is above 0.
  double distance(Vec3d position) const;
  /// px, from the upper left corner: the middle of the first pixel is (0.5, 0.5).
  Vec2d place(Vec3d position) const;
  /// The derivative of place() along a direction at a point: the local affine approximation.
  Vec2d derivative(Vec3d position, Vec3d direction) const;
  bool faces_eye(Vec3d position, Vec3d normal) const;
  /// A number that grows with the distance along the view and is, on every plane, an affine
  /// function of the position in the image: the distance z, or −1 / z with a perspective camera.
  double depth(Vec3d position) const;
  double depth_derivative(Vec3d position, Vec3d direction) const;

 private:
  Vec3d in_view(Vec3d direction) const;  // right, up, along the view

  render::CameraFrame frame_;
  int width_, height_;
  double scale_;  // px per world unit, with perspective at distance 1
};

/// A surfel's resampling filter in the image: the reconstruction kernel, projected by the local
/// affine approximation and convolved with the low-pass filter. Both are Gaussians, so their
/// variances add (the "screen space EWA filter" of Zwicker et al. 2001):
///   ρ(x) = |J| G_V(x − m),   V = J Vᵣ Jᵀ + Vₕ,
/// with the Jacobian J from the tangent plane to the image, Vᵣ = deviation² · I and Vₕ = low_pass ·
/// I.
struct ScreenSplat {
  Vec2d centre;
  Variance2 kernel;      ///< J Vᵣ Jᵀ: of the reconstruction kernel alone
  Variance2 filter;      ///< V
  double image_area;     ///< |J| · area of the surfel, px²: the integral of its weight
  double depth;          ///< ImagePlane::depth() of the surfel
  Vec2d depth_gradient;  ///< of the tangent plane, per px

  /// The surfel's weight at a position relative to the centre, area · ρ. Over a surface that is
  /// sampled evenly the sum of weights is nearly 1.
  double weight(Vec2d offset) const;
};

/// Returns nothing for surfels behind the eye, and for surfels seen from the side, whose area in
/// the image is below 0.1 % of that seen from the front. With a perspective camera, it also returns
/// nothing for surfels nearer than 8 deviations: there, the affine approximation fails and would
/// make splats that cover the image.
std::optional<ScreenSplat> project_surfel(const Surfel& surfel, const ImagePlane& image,
                                          double low_pass);

}  // namespace isosplat
