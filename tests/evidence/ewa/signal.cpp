#include "tests/evidence/ewa/signal.h"

#include <algorithm>
#include <cmath>

#include "native/headless/ray_caster.h"
#include "shared/render/settings/colour_maps.h"
#include "tests/bench/render/reference_normals.h"
#include "tests/evidence/sampling/methods.h"

namespace isosplat {
namespace {

Vec3f as_float(Vec3d v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

/// The colour that a texture gives with linear filtering of decoded sRGB colours.
Vec3f mapped_colour(render::ColourMap map, double scalar) {
  const double place = 255 * std::clamp(scalar, 0.0, 1.0);
  const auto low = std::min<size_t>(static_cast<size_t>(place), 254);
  const auto linear = [&](size_t entry) {
    const uint8_t* c = render::kColourMapTable[static_cast<size_t>(map)][entry];
    return render::to_linear({float(c[0]) / 255, float(c[1]) / 255, float(c[2]) / 255});
  };
  const auto t = static_cast<float>(place - double(low));
  return linear(low) * (1 - t) + linear(low + 1) * t;
}

/// The number of cells that a plane with this normal crosses, per area.
double cells_per_area(const VolumeGrid& grid, Vec3d normal) {
  const Matrix3d edges = grid.cell_edges();
  double sum = 0;
  for (size_t axis = 0; axis < 3; ++axis) sum += std::abs(dot(normal, column(edges, axis)));
  return sum / std::abs(determinant(edges));
}

}  // namespace

double luminance_of(Vec3f linear) {
  return 0.2126 * double(linear.x) + 0.7152 * double(linear.y) + 0.0722 * double(linear.z);
}

Vec3f lit_colour(const render::RenderSettings& settings, const render::CameraFrame& frame,
                 Vec3d position, Vec3d normal, double gradient) {
  const bool shows_gradient = settings.colour_by == render::ColourBy::gradient;
  const double scalar =
      (gradient - settings.colour_low) / (settings.colour_high - settings.colour_low);
  const Vec3f base = shows_gradient ? mapped_colour(settings.colour_map, scalar)
                                    : render::to_linear(settings.isosurfaces.at(0).colour);
  const auto in_camera = [&](Vec3d v) {
    return as_float({dot(v, frame.right), dot(v, frame.up), -dot(v, frame.forward)});
  };
  const Vec3d to_eye = frame.eye - position;
  const Vec3f eye = frame.orthographic ? Vec3f{0, 0, 1} : in_camera(to_eye * (1 / length(to_eye)));
  const Vec3f colour =
      lit(render::light_terms(settings.light, shows_gradient), in_camera(normal), eye, base);
  return {std::clamp(colour.x, 0.0f, 1.0f), std::clamp(colour.y, 0.0f, 1.0f),
          std::clamp(colour.z, 0.0f, 1.0f)};
}

std::vector<Surfel> surfels_of(const TestVolume& volume, double isovalue, double deviation,
                               const Signal& signal) {
  const Index3 n = volume.grid.voxels;
  const float quantized = volume.mapping.quantized_isovalue(isovalue);
  std::vector<Surfel> surfels;
  for (int32_t z = 0; z + 1 < n.z; ++z) {
    for (int32_t y = 0; y + 1 < n.y; ++y) {
      for (int32_t x = 0; x + 1 < n.x; ++x) {
        const CellCorners corners = corners_at(volume, x, y, z);
        if (!is_active(corner_interval(corners), quantized)) continue;
        const Trilinear f(corners);
        const auto point = project_sample(f, SampleBox{}, quantized, ProjectionMethod::exact);
        const Vec3d index{double(x) + double(point->x), double(y) + double(point->y),
                          double(z) + double(point->z)};
        const Vec3d normal = reference_gradient(volume, index);
        const double steepness = length(normal);
        if (!(steepness > 0)) continue;
        const Vec3f own = f.at(*point).gradient;
        Surfel surfel;
        surfel.position = volume.grid.world(index);
        surfel.normal = normal * (1 / steepness);
        surfel.area = 1 / cells_per_area(volume.grid, surfel.normal);
        surfel.deviation = deviation * std::sqrt(surfel.area);
        surfel.colour =
            signal(surfel.position,
                   volume.grid.world_gradient({double(own.x), double(own.y), double(own.z)}));
        surfels.push_back(surfel);
      }
    }
  }
  return surfels;
}

Luminance cast_signal(const TestVolume& volume, double isovalue, const render::Camera& camera,
                      int width, int height, int per_px, const Signal& signal, double background) {
  const RayCaster caster(volume.grid, volume.quantized_values, volume.mapping.has_missing);
  const render::CameraFrame frame = render::camera_frame(camera);
  const double quantized = (isovalue - volume.mapping.offset) / volume.mapping.scale;
  Luminance picture{width * per_px, height * per_px, {}};
  picture.value.assign(size_t(picture.width) * size_t(picture.height), background);
  const double px = 2 * frame.half_height(1) / picture.height;
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      const int up = picture.height - 1 - y;
      const auto hit = caster.cast(camera, picture.width, picture.height, x, up, quantized);
      if (!hit) continue;
      const Vec3d across = frame.right * ((x + 0.5 - 0.5 * picture.width) * px) +
                           frame.up * ((up + 0.5 - 0.5 * picture.height) * px);
      const Vec3d position = frame.orthographic ? frame.eye + across + frame.forward * hit->depth
                                                : frame.eye + (frame.forward + across) * hit->depth;
      picture.at(x, y) = luminance_of(signal(position, hit->normal * hit->gradient));
    }
  }
  return picture;
}

Luminance mean_of_squares(const Luminance& fine, int per_px, int right, int down) {
  Luminance mean{fine.width / per_px, fine.height / per_px, {}};
  mean.value.assign(size_t(mean.width) * size_t(mean.height), 0);
  for (int y = 0; y < mean.height * per_px; ++y) {
    for (int x = 0; x < mean.width * per_px; ++x) {
      mean.at(x / per_px, y / per_px) += fine.at(std::clamp(x + right, 0, fine.width - 1),
                                                 std::clamp(y + down, 0, fine.height - 1)) /
                                         (per_px * per_px);
    }
  }
  return mean;
}

}  // namespace isosplat
