// Time to draw an isosurface coloured by a field of a store, against its own colour, in turn at
// each view: isosplat_field_rate STORE FIELD ISOVALUE [--size PX] [--views N] Prints one line of
// JSON: for each kind, and for close-ups (cells six times as large) the mean times of a frame in
// ms, by the clock and of all threads.
#include <GLES3/gl3.h>

#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>

#include "native/headless/egl_context.h"
#include "native/headless/offscreen_target.h"
#include "native/headless/store_scene.h"
#include "shared/system/store_file/field_file.h"
#include "tests/bench/need.h"

namespace isosplat {
namespace {

constexpr const char* kNames[] = {"quad", "ellipse", "exact", "smooth"};

struct Times {
  double wall = 0, processor = 0;  ///< in seconds
};

Times time_frame(render::Renderer& renderer, int size, GLuint framebuffer) {
  glFinish();
  const auto begin = std::chrono::steady_clock::now();
  const std::clock_t processor_begin = std::clock();
  need(renderer.draw(size, size, framebuffer));
  glFinish();
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - begin;
  return {taken.count(), double(std::clock() - processor_begin) / CLOCKS_PER_SEC};
}

/// Prints the times of a kind, without and with the field.
void measure(render::Renderer& renderer, size_t kind, render::RenderSettings settings,
             render::Camera camera, int size, int views) {
  const OffscreenTarget target(size, size);
  settings.kind = static_cast<render::SplatKind>(std::min<size_t>(kind, 2));
  settings.shading = kind == 3 ? render::Shading::smooth : render::Shading::exact;
  std::array<Times, 2> sums;
  for (int view = -1; view < views; ++view) {  // the first one warms up
    camera.azimuth = 360.0 * view / views;
    renderer.set_camera(camera);
    for (const size_t by_field : {0, 1}) {
      settings.colour_by = by_field ? render::ColourBy::field : render::ColourBy::isosurface;
      renderer.set_settings(settings);
      const Times times = time_frame(renderer, size, target.framebuffer());
      if (view < 0) continue;
      sums[by_field].wall += times.wall;
      sums[by_field].processor += times.processor;
    }
  }
  const auto ms = [views](double seconds) { return seconds / views * 1000; };
  std::printf("{\"plain_ms\":%.3f,\"plain_cpu_ms\":%.3f,\"field_ms\":%.3f,\"field_cpu_ms\":%.3f}",
              ms(sums[0].wall), ms(sums[0].processor), ms(sums[1].wall), ms(sums[1].processor));
}

int run(int argc, char** argv) {
  if (argc < 4) die("usage: isosplat_field_rate STORE FIELD ISOVALUE [--size PX] [--views N]");
  int size = 1024, views = 6;
  for (int i = 4; i + 1 < argc; i += 2) {
    if (!std::strcmp(argv[i], "--size")) size = std::atoi(argv[i + 1]);
    if (!std::strcmp(argv[i], "--views")) views = std::max(1, std::atoi(argv[i + 1]));
  }
  const double isovalue = std::atof(argv[3]);
  const auto store = need(StoreFile::open(argv[1]));
  const auto field = need(open_field(*store, need(find_field(store->info(), argv[2]))));
  const auto context = need(EglContext::create());
  const auto renderer = need(render::Renderer::create());
  VolumePlace place;
  place.field = field.get();
  const auto scene =
      need(show_store(*renderer, *store, std::span(&isovalue, 1), 0, ~uint64_t{0}, 0, place));
  if (!scene.field_range) die("the isosurface has no values of the field");
  render::RenderSettings settings;
  settings.isosurfaces = {{isovalue, {0.85f, 0.8f, 0.7f}, 1}};
  settings.eye_dome = 0;
  settings.colour_low = (*scene.field_range)[0];
  settings.colour_high = (*scene.field_range)[1];
  std::printf("{\"renderer\":\"%s\"", renderer->limits().renderer.c_str());
  for (const int close_up : {1, 6}) {
    render::Camera camera = render::default_camera(store->info().grid);
    camera.distance *= 0.7;
    const double degree = std::acos(-1.0) / 180;
    const double half = std::tan(camera.field_of_view / 2 * degree) / close_up;
    camera.field_of_view = 2 * std::atan(half) / degree;
    for (size_t kind = 0; kind < std::size(kNames); ++kind) {
      std::printf(",\"%s%s\":", close_up > 1 ? "close-up: " : "", kNames[kind]);
      measure(*renderer, kind, settings, camera, size, views);
    }
  }
  std::printf("}\n");
  return 0;
}

}  // namespace
}  // namespace isosplat

int main(int argc, char** argv) {
  return isosplat::run(argc, argv);
}
