#pragma once

#include <functional>
#include <vector>

#include "shared/render/renderer.h"
#include "tests/evidence/ewa/splat.h"
#include "tests/native/test_volume.h"

namespace isosplat {

/// The luminance of a picture, linear, rows from the top.
struct Luminance {
  int width = 0, height = 0;
  std::vector<double> value;

  double& at(int x, int y) { return value[size_t(y) * size_t(width) + size_t(x)]; }
  double at(int x, int y) const { return value[size_t(y) * size_t(width) + size_t(x)]; }
};

double luminance_of(Vec3f linear);

/// The linear colour of a point of the surface. `gradient`: of the cell's trilinear function, in
/// the world.
using Signal = std::function<Vec3f(Vec3d position, Vec3d gradient)>;

/// The colour that settings give to a point of the surface with this normal (world) and length of
/// the gradient, as the renderer computes it (shared/render/settings/light.h, shaders/light.glsl),
/// without occlusion and shadows. Colours stand for the isosurface or for the gradient.
Vec3f lit_colour(const render::RenderSettings& settings, const render::CameraFrame& frame,
                 Vec3d position, Vec3d normal, double gradient);

/// The surface in the resolution of the volume: a surfel for each active cell, at the exact
/// projection of its centre, with the normal by central differences. `deviation`: standard
/// deviation of the reconstruction kernel, relative to the square root of the area that a surfel
/// represents. A plane
/// with normal n crosses Σ |n · eᵢ| / |det (e₁ e₂ e₃)| cells with the edges eᵢ per area.
std::vector<Surfel> surfels_of(const TestVolume& volume, double isovalue, double deviation,
                               const Signal& signal);

/// The ray caster's surface at the centres of `per_px` × `per_px` squares of each pixel, as one
/// picture with a pixel for each square. It has `background` where there is no surface.
Luminance cast_signal(const TestVolume& volume, double isovalue, const render::Camera& camera,
                      int width, int height, int per_px, const Signal& signal,
                      double background = 0);

/// The mean of the squares of each pixel. `right`, `down`: the squares by which the pixels are
/// moved before. Beyond the picture's end its last squares are repeated.
Luminance mean_of_squares(const Luminance& fine, int per_px, int right = 0, int down = 0);

}  // namespace isosplat
