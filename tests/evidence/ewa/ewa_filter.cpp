#include "tests/evidence/ewa/ewa_filter.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace isosplat {
namespace {

constexpr double kNothing = std::numeric_limits<double>::infinity();

/// Calls f(x, y, offset) for each pixel whose centre is in the ellipse vᵀ V⁻¹ v ≤ cutoff².
template <class F>
void for_pixels(const EwaPicture& picture, Vec2d centre, const Variance2& variance, double cutoff,
                F f) {
  const double half_width = cutoff * std::sqrt(variance.xx),
               half_height = cutoff * std::sqrt(variance.yy);
  const auto first = [](double low) { return std::max(0.0, std::ceil(low - 0.5)); };
  const auto last = [](double high, int size) {
    return std::min(size - 1.0, std::floor(high - 0.5));
  };
  const int x0 = static_cast<int>(std::min(first(centre.x - half_width), 1e6)),
            y0 = static_cast<int>(std::min(first(centre.y - half_height), 1e6));
  const int x1 = static_cast<int>(std::max(last(centre.x + half_width, picture.width), -1.0)),
            y1 = static_cast<int>(std::max(last(centre.y + half_height, picture.height), -1.0));
  for (int y = y0; y <= y1; ++y) {
    for (int x = x0; x <= x1; ++x) {
      const Vec2d offset{x + 0.5 - centre.x, y + 0.5 - centre.y};
      if (variance.inverse_form(offset) <= cutoff * cutoff) f(x, y, offset);
    }
  }
}

void mark_visible(const ScreenSplat& splat, const EwaPicture& picture, double cutoff,
                  std::vector<double>& nearest) {
  bool covers = false;
  for_pixels(picture, splat.centre, splat.kernel, cutoff, [&](int x, int y, Vec2d offset) {
    covers = true;
    const double depth =
        splat.depth + splat.depth_gradient.x * offset.x + splat.depth_gradient.y * offset.y;
    double& here = nearest[picture.at(x, y)];
    here = std::min(here, depth);
  });
  const double x = std::floor(splat.centre.x), y = std::floor(splat.centre.y);
  if (covers || x < 0 || y < 0 || x >= picture.width || y >= picture.height) return;
  double& here = nearest[picture.at(static_cast<int>(x), static_cast<int>(y))];
  here = std::min(here, splat.depth);
}

}  // namespace

EwaPicture draw_ewa(std::span<const Surfel> surfels, const ImagePlane& image,
                    const EwaSettings& settings) {
  EwaPicture picture{image.width(), image.height(), {}, {}, {}};
  const size_t pixels = size_t(picture.width) * size_t(picture.height);
  picture.colour.resize(pixels);
  picture.weight.assign(pixels, 0);
  picture.coverage.assign(pixels, 0);
  std::vector<double> away(pixels, 0.0);
  std::vector<double> nearest(pixels, kNothing);
  for (const Surfel& surfel : surfels) {
    if (const auto splat = project_surfel(surfel, image, settings.low_pass)) {
      mark_visible(*splat, picture, settings.visible_cutoff, nearest);
    }
  }

  std::vector<Vec3d> sums(pixels);
  const Vec3d forward = image.frame().forward;
  for (const Surfel& surfel : surfels) {
    const auto splat = project_surfel(surfel, image, settings.low_pass);
    if (!splat) continue;
    const double threshold =
        settings.depth_threshold * image.depth_derivative(surfel.position, forward) +
        settings.cutoff * std::sqrt(splat->filter.form(splat->depth_gradient));
    const bool faces_eye = image.faces_eye(surfel.position, surfel.normal);
    const Vec3d colour{surfel.colour.x, surfel.colour.y, surfel.colour.z};
    for_pixels(picture, splat->centre, splat->filter, settings.cutoff,
               [&](int x, int y, Vec2d offset) {
                 const size_t i = picture.at(x, y);
                 const double weight = splat->weight(offset);
                 (faces_eye ? picture.coverage : away)[i] += weight;
                 if (splat->depth - threshold > nearest[i]) return;
                 sums[i] = sums[i] + colour * weight;
                 picture.weight[i] += weight;
               });
  }
  for (size_t i = 0; i < pixels; ++i) {
    picture.coverage[i] = std::min(1.0, std::max(picture.coverage[i], away[i]));
    if (!(picture.weight[i] > 0)) continue;
    const Vec3d mean = sums[i] * (1 / picture.weight[i]);
    picture.colour[i] = {static_cast<float>(mean.x), static_cast<float>(mean.y),
                         static_cast<float>(mean.z)};
  }
  return picture;
}

}  // namespace isosplat
