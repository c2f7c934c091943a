#include "tests/evidence/ewa/checker.h"

#include <cmath>

namespace isosplat {

Checker::Checker(int cells, int square_cells) : square(square_cells) {
  volume = sampled_volume({cells + 1, cells + 1, 4}, {1, 1, 1}, [&](Vec3d p) {
    const int squares = static_cast<int>(p.x) / square + static_cast<int>(p.y) / square;
    return kIsovalue + (squares % 2 ? kHigh : kLow) * (p.z - plane());
  });
}

render::RenderSettings Checker::settings() const {
  render::RenderSettings settings;
  settings.isosurfaces = {{kIsovalue, {1, 1, 1}, 1}};
  settings.background = {0, 0, 0, 1};
  settings.colour_by = render::ColourBy::gradient;
  // From entry 40 to 88 of 255, the luminance of this map is linear to within 2 % of its contrast.
  // So the mean of several colours has the luminance of the colour of their mean scalar.
  settings.colour_map = render::ColourMap::turbo;
  const double per_entry = (kHigh - kLow) / (88 - 40);
  settings.colour_low = kLow - 40 * per_entry;
  settings.colour_high = settings.colour_low + 255 * per_entry;
  settings.light.occlusion = settings.light.shadow = 0;
  settings.eye_dome = 0;
  return settings;
}

Signal Checker::signal(const render::Camera& camera) const {
  return [settings = settings(), frame = render::camera_frame(camera)](Vec3d position,
                                                                       Vec3d gradient) {
    return lit_colour(settings, frame, position, {0, 0, 1}, length(gradient));
  };
}

std::optional<Vec3d> Checker::point_at(const ImagePlane& image, Vec2d place) const {
  const render::CameraFrame& frame = image.frame();
  const double px = 2 * frame.half_height(1) / image.height();
  const Vec3d across = frame.right * ((place.x - 0.5 * image.width()) * px) +
                       frame.up * ((0.5 * image.height() - place.y) * px);
  const Vec3d origin = frame.orthographic ? frame.eye + across : frame.eye;
  const Vec3d direction = frame.orthographic ? frame.forward : frame.forward + across;
  const double t = (plane() - origin.z) / direction.z;
  if (!(t > 0) || !std::isfinite(t)) return std::nullopt;
  return origin + direction * t;
}

bool Checker::holds(Vec3d point, double margin) const {
  const auto within = [&](double at, int32_t voxels) {
    return at >= margin && at <= voxels - 1 - margin;
  };
  return within(point.x, volume.grid.voxels.x) && within(point.y, volume.grid.voxels.y);
}

Vec2d Checker::frequency(const ImagePlane& image, Vec3d point, int m, int n) const {
  const Vec2d x = image.derivative(point, {1, 0, 0}), y = image.derivative(point, {0, 1, 0});
  const double determinant = x.x * y.y - y.x * x.y;
  const double along_x = 0.5 * m / square, along_y = 0.5 * n / square;  // cycles per cell
  return {(along_x * y.y - along_y * x.y) / determinant,
          (along_y * x.x - along_x * y.x) / determinant};
}

double Checker::phase(Vec3d point, int m, int n) const {
  return 0.5 * (m * point.x + n * point.y) / square;
}

}  // namespace isosplat
