// Compares alias and blur of the renderer's splats and of an EWA resampling filter (Zwicker et al.
// 2001) with the ray caster's picture at many positions in each pixel.
//
//   isosplat_ewa_study VOLUME STORE ISOVALUE PICTURES
//
// Prints a line of JSON for each figure. PICTURES: a folder for pictures of both scenes. The first
// scene is a plane with a checker pattern, which recedes to the horizon; its edges are measured
// from the front. The second scene is the volume, as a whole and close up. The light is without
// occlusion, shadows and edge shading, which do not concern the filters.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <numbers>
#include <span>
#include <string>

#include "native/headless/draw_image.h"
#include "native/headless/egl_context.h"
#include "native/headless/ray_caster.h"
#include "native/headless/store_scene.h"
#include "tests/bench/need.h"
#include "tests/bench/render/reference_normals.h"
#include "tests/bench/render/volume.h"
#include "tests/evidence/ewa/contrast.h"
#include "tests/evidence/ewa/pictures.h"
#include "tests/evidence/ewa/spectrum.h"

namespace isosplat {
namespace {

constexpr int kTruthPerPx = 8;  // squares of a pixel of the checker along each axis
constexpr int kPlaces = 4;      // positions in a pixel of the volume, along each axis
constexpr double kBands[][2] = {{0.05, 0.15}, {0.15, 0.25}, {0.25, 0.35}, {0.35, 0.45}};
constexpr const char* kBandNames[] = {"0.1", "0.2", "0.3", "0.4"};

struct Way {
  const char* name;
  double deviation;  ///< of EWA's kernels, relative to the distance of samples; 0: the renderer
  render::SplatKind kind = render::SplatKind::exact;
  render::Shading shading = render::Shading::smooth;
  bool still = false;
};

constexpr Way kWays[] = {
    {"EWA, kernels of 0.5", 0.5},
    {"EWA, kernels of 0.7", 0.7},
    {"exact, smooth, still", 0, render::SplatKind::exact, render::Shading::smooth, true},
    {"exact, smooth", 0, render::SplatKind::exact, render::Shading::smooth, false},
    {"exact, still", 0, render::SplatKind::exact, render::Shading::exact, true},
    {"exact", 0, render::SplatKind::exact, render::Shading::exact, false},
    {"ellipses, smooth, still", 0, render::SplatKind::ellipse, render::Shading::smooth, true},
    {"ellipses, smooth", 0, render::SplatKind::ellipse, render::Shading::smooth, false},
    {"squares, still", 0, render::SplatKind::quad, render::Shading::exact, true},
    {"squares", 0, render::SplatKind::quad, render::Shading::exact, false},
};
constexpr const char* kMean = "mean of 8 × 8 rays";

void report(const std::string& scene, const char* way, const std::string& measure, const char* unit,
            double value) {
  std::printf(
      "{\"scene\":\"%s\",\"way\":\"%s\",\"measure\":\"%s\",\"unit\":\"%s\",\"value\":%.6g}\n",
      scene.c_str(), way, measure.c_str(), unit, value);
  std::fflush(stdout);
}

/// A volume in the renderer, and the same surface as surfels, whose colours are computed for a
/// camera.
struct Subject {
  const TestVolume& volume;
  double isovalue;
  render::RenderSettings settings;
  std::function<Signal(const render::Camera&)> signal;
};

/// The surfels of a method that uses them. With an orthographic camera, colours do not depend on
/// its target.
std::vector<Surfel> surfels_of(const Subject& subject, const Way& way,
                               const render::Camera& camera) {
  if (!(way.deviation > 0)) return {};
  return surfels_of(subject.volume, subject.isovalue, way.deviation, subject.signal(camera));
}

Image draw(render::Renderer& renderer, const Subject& subject, const Way& way,
           std::span<const Surfel> surfels, const render::Camera& camera, int size) {
  if (way.deviation > 0) {
    return over_black(draw_ewa(surfels, ImagePlane(camera, size, size)));
  }
  render::RenderSettings settings = subject.settings;
  settings.kind = way.kind;
  settings.shading = way.shading;
  renderer.set_settings(settings);
  renderer.set_camera(camera);
  return need(draw_image(renderer, size, size, nullptr, way.still));
}

void save(const Image& image, const std::string& folder, const char* scene, const char* name) {
  need(write_png(folder + "/" + scene + "_" + name + ".png", image));
}

/// The name of the picture of this method, or nullptr if the document does not show it.
const char* picture_name(const char* way) {
  static const std::map<std::string, const char*> names{{"EWA, kernels of 0.5", "ewa"},
                                                        {"exact, smooth, still", "still"},
                                                        {"exact", "exact"},
                                                        {"squares", "squares"},
                                                        {kMean, "mean"}};
  const auto found = names.find(way);
  return found == names.end() ? nullptr : found->second;
}

void show_checker(render::Renderer& renderer, const Checker& checker) {
  if (show_volume(renderer, checker.volume, Checker::kIsovalue, Checker::kIsovalue) == 0) {
    die("The renderer does not take the checker's samples");
  }
}

Subject subject_of(const Checker& checker) {
  return {checker.volume, Checker::kIsovalue, checker.settings(),
          [&checker](const render::Camera& camera) { return checker.signal(camera); }};
}

/// Ends the program unless exact splats show the ray caster's surface at the pixels' centres: if
/// not, the figures would compare different surfaces.
void check_truth(const Luminance& exact, const Luminance& cast, double contrast) {
  double sum = 0;
  for (size_t i = 0; i < exact.value.size(); ++i) sum += std::abs(exact.value[i] - cast.value[i]);
  const double mean = sum / double(exact.value.size()) / contrast;
  if (mean > 0.01) {
    die("Expected exact splats to show the ray caster's surface, found a mean difference of " +
        std::to_string(mean) + " of the contrast");
  }
}

void study_plane(render::Renderer& renderer, const std::string& folder) {
  constexpr int kSize = 384;
  const Checker checker(1024, 4);
  show_checker(renderer, checker);
  const Subject subject = subject_of(checker);
  // 40 cells above the plane; the horizon is near the upper edge.
  render::Camera camera;
  camera.azimuth = 30;
  camera.elevation = 16;
  camera.field_of_view = 40;
  camera.distance = 40 / std::sin(16 * std::numbers::pi / 180);
  camera.target = {630, 180, checker.plane()};
  const ImagePlane image(camera, kSize, kSize);
  const CheckerLevels levels = levels_of(checker, camera);
  const Luminance fine = cast_signal(checker.volume, Checker::kIsovalue, camera, kSize, kSize,
                                     kTruthPerPx, subject.signal(camera));
  const auto measure = [&](const char* way, const Luminance& picture) {
    report("checker", way, "alias", "%", 100 * checker_alias(picture, checker, image, levels));
    for (size_t i = 0; i < std::size(kBands); ++i) {
      const auto amplitude = [&](const Luminance& of, int per_px) {
        return wave_amplitude(of, per_px, checker, image, levels, kBands[i][0], kBands[i][1]);
      };
      report("checker", way, std::string("contrast at ") + kBandNames[i] + " cycles per px", "",
             amplitude(picture, 1) / amplitude(fine, kTruthPerPx));
    }
  };
  const auto keep = [&](const char* way, const Image& picture) {
    if (const char* name = picture_name(way)) {
      save(cropped(encoded(decoded(picture)), 64, 20, 256, 192, 1), folder, "checker", name);
    }
  };
  const Luminance mean = mean_of_squares(fine, kTruthPerPx);
  measure(kMean, mean);
  keep(kMean, encoded(mean));
  for (const Way& way : kWays) {
    const auto surfels = surfels_of(subject, way, camera);
    const Image picture = draw(renderer, subject, way, surfels, camera, kSize);
    const Luminance luminance = decoded(picture);
    if (way.name == std::string("exact")) {
      check_truth(luminance,
                  cast_signal(checker.volume, Checker::kIsovalue, camera, kSize, kSize, 1,
                              subject.signal(camera)),
                  levels.bright - levels.dark);
    }
    measure(way.name, luminance);
    keep(way.name, picture);
  }
}

/// Measures edges of the pattern from the front. They are turned by 10°, so that they cross pixels
/// at all positions.
void study_edges(render::Renderer& renderer, int cells, int square, double px_per_cell,
                 const char* measure) {
  constexpr int kSize = 256;
  const Checker checker(cells, square);
  show_checker(renderer, checker);
  const Subject subject = subject_of(checker);
  render::Camera camera;
  camera.orthographic = true;
  camera.azimuth = 0;
  camera.elevation = 90;
  camera.roll = 10;
  camera.target = {0.5 * cells, 0.5 * cells, checker.plane()};
  camera.distance = 0.5 * kSize / px_per_cell / render::camera_frame(camera).tan_half_field_of_view;
  const ImagePlane image(camera, kSize, kSize);
  const CheckerLevels levels = levels_of(checker, camera);
  const Luminance fine = cast_signal(checker.volume, Checker::kIsovalue, camera, kSize, kSize,
                                     kTruthPerPx, subject.signal(camera));
  report("checker", "surface", measure, "px",
         edge_width(fine, kTruthPerPx, checker, image, levels));
  report("checker", kMean, measure, "px",
         edge_width(mean_of_squares(fine, kTruthPerPx), 1, checker, image, levels));
  for (const Way& way : kWays) {
    const auto surfels = surfels_of(subject, way, camera);
    const Luminance picture = decoded(draw(renderer, subject, way, surfels, camera, kSize));
    report("checker", way.name, measure, "px", edge_width(picture, 1, checker, image, levels));
  }
}

/// The camera with a shifted image: each pixel shows the point that was this many px to its right
/// and below it. Only for orthographic cameras, for which the shift is exact at all pixels.
render::Camera moved(render::Camera camera, double right_px, double down_px, int size) {
  const render::CameraFrame frame = render::camera_frame(camera);
  const double px = 2 * frame.half_height(1) / size;
  camera.target = camera.target + frame.right * (right_px * px) - frame.up * (down_px * px);
  return camera;
}

void study_view(render::Renderer& renderer, const Subject& subject, const std::string& scene,
                const char* picture_scene, const render::Camera& camera,
                const std::string& folder) {
  constexpr int kSize = 256;
  const Luminance surface = cast_signal(subject.volume, subject.isovalue, camera, kSize, kSize,
                                        kPlaces, subject.signal(camera));
  const Spectrum truth(surface, kPlaces);
  const auto measure = [&](const char* way, const Spectrum& spectrum) {
    report(scene, way, "alias", "%", 100 * spectrum.alias(truth));
    for (size_t i = 0; i < std::size(kBands); ++i) {
      report(scene, way, std::string("contrast at ") + kBandNames[i] + " cycles per px", "",
             spectrum.contrast(truth, kBands[i][0], kBands[i][1]));
    }
  };
  const auto keep = [&](const char* way, const Image& picture) {
    if (const char* name = picture_name(way)) {
      save(cropped(picture, 64, 64, 128, 128, 2), folder, picture_scene, name);
    }
  };
  measure("surface", truth);
  const Luminance finer = cast_signal(subject.volume, subject.isovalue, camera, kSize, kSize,
                                      kTruthPerPx, subject.signal(camera));
  // The positions differ from the pixels' centres by whole squares of the finer picture.
  static_assert(kTruthPerPx == 2 * kPlaces);
  std::vector<Luminance> means;
  for (int i = 0; i < kPlaces * kPlaces; ++i) {
    means.push_back(mean_of_squares(finer, kTruthPerPx, 2 * (i % kPlaces) + 1 - kPlaces,
                                    2 * (i / kPlaces) + 1 - kPlaces));
  }
  measure(kMean, Spectrum(interleaved(means, kPlaces), kPlaces));
  keep(kMean, encoded(mean_of_squares(finer, kTruthPerPx)));
  for (const Way& way : kWays) {
    const auto surfels = surfels_of(subject, way, camera);
    const auto draw_at = [&](const render::Camera& at) {
      return draw(renderer, subject, way, surfels, at, kSize);
    };
    std::vector<Luminance> pictures;
    for (int i = 0; i < kPlaces * kPlaces; ++i) {
      const auto offset = [](int place) { return (place + 0.5) / kPlaces - 0.5; };
      pictures.push_back(
          decoded(draw_at(moved(camera, offset(i % kPlaces), offset(i / kPlaces), kSize))));
    }
    measure(way.name, Spectrum(interleaved(pictures, kPlaces), kPlaces));
    keep(way.name, draw_at(camera));
  }
}

/// A camera that looks at a point of the surface near the middle, so near that a cell covers
/// `px_per_cell`.
render::Camera close_camera(const TestVolume& volume, double isovalue, render::Camera camera,
                            double px_per_cell) {
  constexpr int kSize = 256;
  const RayCaster caster(volume.grid, volume.quantized_values, volume.mapping.has_missing);
  const double quantized = (isovalue - volume.mapping.offset) / volume.mapping.scale;
  const render::CameraFrame frame = render::camera_frame(camera);
  const auto hit = caster.cast(camera, kSize, kSize, kSize / 2, kSize / 2, quantized);
  if (!hit) die("Expected a surface in the middle of the picture, found none");
  camera.target = frame.eye + frame.forward * hit->depth;
  camera.distance = 0.5 * kSize / px_per_cell / frame.tan_half_field_of_view;
  return camera;
}

int run(int argc, char** argv) {
  if (argc != 5) {
    std::fprintf(stderr, "usage: isosplat_ewa_study VOLUME STORE ISOVALUE PICTURES\n");
    return 2;
  }
  const std::string folder = argv[4];
  const double isovalue = std::atof(argv[3]);
  const auto context = need(EglContext::create());
  const auto renderer = need(render::Renderer::create());
  study_plane(*renderer, folder);
  study_edges(*renderer, 64, 8, 8, "edge width, cells of 8 px");
  study_edges(*renderer, 768, 32, 0.5, "edge width, cells of 0.5 px");

  const TestVolume volume = load_volume(argv[1]);
  render::RenderSettings settings;
  settings.isosurfaces = {{isovalue, {0.75f, 0.75f, 0.75f}, 1}};
  settings.background = {0, 0, 0, 1};
  settings.light.occlusion = settings.light.shadow = 0;
  settings.eye_dome = 0;
  const Subject subject{
      volume, isovalue, settings, [&](const render::Camera& camera) -> Signal {
        return [&, frame = render::camera_frame(camera)](Vec3d position, Vec3d gradient) {
          const Vec3d index =
              multiply_transposed(volume.grid.dual_edges(), position - volume.grid.origin);
          const Vec3d smooth = reference_gradient(volume, index);
          const double steepness = length(smooth);
          const Vec3d normal = steepness > 0 ? smooth * (1 / steepness) : Vec3d{0, 0, 1};
          return lit_colour(settings, frame, position, normal, length(gradient));
        };
      }};
  const auto store = need(StoreFile::open(argv[2]));
  need(show_store(*renderer, *store, std::span(&isovalue, 1), 0, ~uint64_t{0}));
  const render::Camera whole = render::default_camera(volume.grid, 1, true);
  const render::Camera close = close_camera(volume, isovalue, whole, 6);
  study_view(*renderer, subject, "whole", "whole", whole, folder);
  study_view(*renderer, subject, "close up", "close", close, folder);
  return 0;
}

}  // namespace
}  // namespace isosplat

int main(int argc, char** argv) {
  return isosplat::run(argc, argv);
}
