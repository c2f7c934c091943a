// Time to draw each splat kind, and a triangle mesh in the same renderer: views around the volume
// as in the paper's experiment (section 6), the kinds in turn at each view. isosplat_frame_rate
// VOLUME ISOVALUE MESH [--size PX] [--views N] [--kind K] [--band LOW HIGH] Prints one line of
// JSON. --band: all samples that are active in this range are resident, as in chunks; without it,
// only those that are active for the isovalue.
#include <GLES3/gl3.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <optional>

#include "native/headless/egl_context.h"
#include "tests/bench/render/volume.h"

namespace isosplat {
namespace {

struct Options {
  double isovalue, low, high;
  int size = 1024, views = 36;
  std::string kind;  ///< empty: all
};

Options parse_options(int argc, char** argv) {
  Options options;
  options.isovalue = options.low = options.high = std::atof(argv[2]);
  for (int i = 4; i < argc; ++i) {
    const auto next = [&] { return i + 1 < argc ? argv[++i] : "0"; };
    if (!std::strcmp(argv[i], "--size"))
      options.size = std::atoi(next());
    else if (!std::strcmp(argv[i], "--views"))
      options.views = std::max(1, std::atoi(next()));
    else if (!std::strcmp(argv[i], "--kind"))
      options.kind = next();
    else if (!std::strcmp(argv[i], "--band")) {
      options.low = std::atof(next());
      options.high = std::atof(next());
    }
  }
  return options;
}

/// A framebuffer of size² pixels.
GLuint make_framebuffer(int size) {
  GLuint framebuffer = 0, colour = 0;
  glGenFramebuffers(1, &framebuffer);
  glGenRenderbuffers(1, &colour);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  glBindRenderbuffer(GL_RENDERBUFFER, colour);
  glRenderbufferStorage(GL_RENDERBUFFER, GL_RGBA8, size, size);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, colour);
  return framebuffer;
}

constexpr const char* kNames[] = {"quad", "ellipse", "exact", "smooth", "mesh"};
constexpr int kMesh = 4;

/// Time for all views, by kNames.
struct Times {
  double seconds[5] = {}, processor_seconds[5] = {};
};

/// Draws all kinds in turn at each view. Returns nullopt if a picture cannot be drawn.
std::optional<Times> draw_views(Renderer& splats, Renderer& mesh, const Options& options,
                                Camera camera) {
  const GLuint framebuffer = make_framebuffer(options.size);
  RenderSettings settings;
  settings.isosurfaces = {{options.isovalue, {0.85f, 0.8f, 0.7f}, 1}};
  settings.eye_dome = 0;
  Times times;
  for (int view = -1; view < options.views; ++view) {  // the first one warms up
    camera.azimuth = 360.0 * view / options.views;
    for (int kind = 0; kind < 5; ++kind) {
      if (kind != kMesh && !options.kind.empty() && options.kind != kNames[kind]) continue;
      Renderer& renderer = kind == kMesh ? mesh : splats;
      settings.kind = static_cast<SplatKind>(std::min(kind, 2));
      settings.shading = kind == 3 ? Shading::smooth : Shading::exact;
      renderer.set_settings(settings);
      renderer.set_camera(camera);
      glFinish();
      const auto begin = std::chrono::steady_clock::now();
      const std::clock_t processor_begin = std::clock();
      if (!renderer.draw(options.size, options.size, framebuffer)) return std::nullopt;
      glFinish();
      const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - begin;
      if (view < 0) continue;
      times.seconds[kind] += taken.count();
      times.processor_seconds[kind] += double(std::clock() - processor_begin) / CLOCKS_PER_SEC;
    }
  }
  return times;
}

int run(int argc, char** argv) {
  if (argc < 4) {
    std::fprintf(stderr, "usage: isosplat_frame_rate VOLUME ISOVALUE MESH [--size PX]\n");
    return 2;
  }
  const Options options = parse_options(argc, argv);
  const TestVolume volume = load_volume(argv[1]);
  const auto context = EglContext::create();
  auto created = context ? Renderer::create()
                         : Result<std::unique_ptr<Renderer>>(tl::unexpected(context.error()));
  // The mesh has a renderer of its own, so that switching costs nothing.
  auto other = created ? Renderer::create()
                       : Result<std::unique_ptr<Renderer>>(tl::unexpected(created.error()));
  if (!other) {
    std::fprintf(stderr, "%s\n", other.error().message.c_str());
    return 1;
  }
  Renderer &splats = **created, &mesh = **other;
  const uint64_t samples = show_volume(splats, volume, options.low, options.high);
  mesh.set_volume(volume.grid, volume.mapping);
  const uint64_t triangles = show_mesh(mesh, volume.grid, argv[3]);
  Camera camera = default_camera(volume.grid);
  camera.distance *= 0.7;
  const auto times = draw_views(splats, mesh, options, camera);
  if (!times) return 1;
  std::printf("{\"renderer\":\"%s\",\"samples\":%llu,\"triangles\":%llu",
              splats.limits().renderer.c_str(), static_cast<unsigned long long>(samples),
              static_cast<unsigned long long>(triangles));
  for (int kind = 0; kind < 5; ++kind) {
    std::printf(",\"%s_ms\":%.3f,\"%s_cpu_ms\":%.3f", kNames[kind],
                times->seconds[kind] / options.views * 1000, kNames[kind],
                times->processor_seconds[kind] / options.views * 1000);
  }
  std::printf("}\n");
  return 0;
}

}  // namespace
}  // namespace isosplat

int main(int argc, char** argv) {
  return isosplat::run(argc, argv);
}
