#include "tests/evidence/ewa/splat.h"

#include <cmath>
#include <numbers>

namespace isosplat {
namespace {

constexpr double kLeastCosine = 1e-3;
constexpr double kLeastDeviations = 8;

/// Two directions of unit length that are perpendicular to the normal, and to each other.
struct Tangents {
  Vec3d u, v;
};

Tangents tangents_of(Vec3d normal) {
  const Vec3d other = std::abs(normal.x) < 0.7 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0};
  const Vec3d across = cross(normal, other);
  const Vec3d u = across * (1 / length(across));
  return {u, cross(normal, u)};
}

}  // namespace

ImagePlane::ImagePlane(const render::Camera& camera, int width, int height)
    : frame_(render::camera_frame(camera)),
      width_(width),
      height_(height),
      scale_(height / (2 * frame_.half_height(1))) {}

Vec3d ImagePlane::in_view(Vec3d direction) const {
  return {dot(direction, frame_.right), dot(direction, frame_.up), dot(direction, frame_.forward)};
}

double ImagePlane::distance(Vec3d position) const {
  return dot(position - frame_.eye, frame_.forward);
}

Vec2d ImagePlane::place(Vec3d position) const {
  const Vec3d p = in_view(position - frame_.eye);
  const double scale = frame_.orthographic ? scale_ : scale_ / p.z;
  return {0.5 * width_ + scale * p.x, 0.5 * height_ - scale * p.y};
}

Vec2d ImagePlane::derivative(Vec3d position, Vec3d direction) const {
  const Vec3d p = in_view(position - frame_.eye), d = in_view(direction);
  if (frame_.orthographic) return {scale_ * d.x, -scale_ * d.y};
  const double scale = scale_ / p.z;
  return {scale * (d.x - p.x / p.z * d.z), -scale * (d.y - p.y / p.z * d.z)};
}

bool ImagePlane::faces_eye(Vec3d position, Vec3d normal) const {
  return dot(normal, frame_.orthographic ? frame_.forward : position - frame_.eye) < 0;
}

double ImagePlane::depth(Vec3d position) const {
  const double z = distance(position);
  return frame_.orthographic ? z : -1 / z;
}

double ImagePlane::depth_derivative(Vec3d position, Vec3d direction) const {
  const double along = in_view(direction).z;
  if (frame_.orthographic) return along;
  const double z = distance(position);
  return along / (z * z);
}

double ScreenSplat::weight(Vec2d offset) const {
  return image_area / (2 * std::numbers::pi * std::sqrt(filter.determinant())) *
         std::exp(-0.5 * filter.inverse_form(offset));
}

std::optional<ScreenSplat> project_surfel(const Surfel& surfel, const ImagePlane& image,
                                          double low_pass) {
  const double least_distance = kLeastDeviations * surfel.deviation;
  if (!image.frame().orthographic && !(image.distance(surfel.position) > least_distance)) {
    return std::nullopt;
  }
  const auto [u, v] = tangents_of(surfel.normal);
  const Vec2d by_u = image.derivative(surfel.position, u);
  const Vec2d by_v = image.derivative(surfel.position, v);
  const double jacobian = by_u.x * by_v.y - by_v.x * by_u.y;
  const Vec2d by_right = image.derivative(surfel.position, image.frame().right);
  const double facing = by_right.x * by_right.x;  // |J| of a plane that faces the eye
  if (!(std::abs(jacobian) > kLeastCosine * facing)) return std::nullopt;

  ScreenSplat splat{};
  splat.centre = image.place(surfel.position);
  const double variance = surfel.deviation * surfel.deviation;
  splat.kernel = {variance * (by_u.x * by_u.x + by_v.x * by_v.x),
                  variance * (by_u.x * by_u.y + by_v.x * by_v.y),
                  variance * (by_u.y * by_u.y + by_v.y * by_v.y)};
  splat.filter = {splat.kernel.xx + low_pass, splat.kernel.xy, splat.kernel.yy + low_pass};
  splat.image_area = std::abs(jacobian) * surfel.area;
  splat.depth = image.depth(surfel.position);
  // For the gradient g of the depth in the image, g · by_u is the derivative along u, and likewise
  // for v.
  const double along_u = image.depth_derivative(surfel.position, u);
  const double along_v = image.depth_derivative(surfel.position, v);
  splat.depth_gradient = {(along_u * by_v.y - along_v * by_u.y) / jacobian,
                          (along_v * by_u.x - along_u * by_v.x) / jacobian};
  return splat;
}

}  // namespace isosplat
