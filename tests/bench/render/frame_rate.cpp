// Time to draw each splat kind, and a triangle mesh in the same renderer: views around the volume
// as in the paper's experiment (section 6), the kinds in turn at each view. isosplat_frame_rate
// VOLUME ISOVALUE MESH [--size PX] [--views N] [--kind K] [--band LOW HIGH] [--close-up F]
// [--still]
// [--stages] [--smooth]
// Prints one line of JSON. --smooth: smooth shading for all kinds, not for "smooth" alone.
// --close-up: cells are F times as large in the picture. --still: times a picture of the mean of a
// still view, with ambient occlusion and shadows, instead of a frame.
// --band: all samples that are active in this range are resident, as in chunks; without it, only
// those that are active for the isovalue. --stages: prints a table instead, of the processor time
// of all threads by stage of a frame. Other programs on the machine do not change it.
#include <GLES3/gl3.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <optional>

#include "native/headless/egl_context.h"
#include "native/headless/offscreen_target.h"
#include "tests/bench/render/volume.h"

namespace isosplat {
namespace {

struct Options {
  double isovalue, low, high, close_up = 1;
  int size = 1024, views = 36;
  std::string kind;  ///< empty: all
  bool still = false, stages = false, smooth = false;
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
    else if (!std::strcmp(argv[i], "--still"))
      options.still = true;
    else if (!std::strcmp(argv[i], "--stages"))
      options.stages = true;
    else if (!std::strcmp(argv[i], "--smooth"))
      options.smooth = true;
    else if (!std::strcmp(argv[i], "--close-up"))
      options.close_up = std::max(1.0, std::atof(next()));
    else if (!std::strcmp(argv[i], "--band")) {
      options.low = std::atof(next());
      options.high = std::atof(next());
    }
  }
  return options;
}

constexpr const char* kNames[] = {"quad", "ellipse", "exact", "smooth", "mesh"};
constexpr size_t kMesh = 4;

/// Times in seconds of a frame, or of all views.
struct Times {
  double wall = 0;
  double processor = 0;  ///< of all threads
  double vertices = 0;   ///< the part of `processor` of vertex shaders and culling
  double picture = 0;  ///< the part of an empty frame: clearing, lighting and composing all pixels
  uint64_t samples = 0;  ///< whose vertex shaders run

  void add(const Times& other) {
    wall += other.wall;
    processor += other.processor;
    vertices += other.vertices;
    picture += other.picture;
    samples += other.samples;
  }
};

/// Draws a frame, or with `still` the third picture of a mean. Returns nullopt if it cannot be
/// drawn.
std::optional<Times> time_frame(render::Renderer& renderer, int size, GLuint framebuffer,
                                bool still = false) {
  if (still &&
      (!renderer.draw(size, size, framebuffer) || !renderer.refine(size, size, framebuffer))) {
    return std::nullopt;
  }
  glFinish();
  const auto begin = std::chrono::steady_clock::now();
  const std::clock_t processor_begin = std::clock();
  const auto drawn =
      still ? renderer.refine(size, size, framebuffer) : renderer.draw(size, size, framebuffer);
  if (!drawn) return std::nullopt;
  glFinish();
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - begin;
  Times times;
  times.wall = taken.count();
  times.processor = double(std::clock() - processor_begin) / CLOCKS_PER_SEC;
  times.samples = drawn->samples_drawn;
  return times;
}

/// Adds the times of the stages to those of a frame that was drawn last. Without rasterization, the
/// depths of that frame stay, so that the vertex shaders drop the samples that it occludes.
bool time_stages(render::Renderer& renderer, int size, GLuint framebuffer, Times& times) {
  glEnable(GL_RASTERIZER_DISCARD);
  const auto vertices = time_frame(renderer, size, framebuffer);
  glDisable(GL_RASTERIZER_DISCARD);
  const render::RenderSettings settings = renderer.settings();
  render::RenderSettings empty = settings;
  empty.isosurfaces[0].opacity = 0;
  renderer.set_settings(empty);
  const auto picture = time_frame(renderer, size, framebuffer);
  renderer.set_settings(settings);
  if (!vertices || !picture) return false;
  times.vertices = vertices->processor;
  times.picture = picture->processor;
  return true;
}

/// Draws all kinds in turn at each view. Returns nullopt if a picture cannot be drawn.
std::optional<std::array<Times, 5>> draw_views(render::Renderer& splats, render::Renderer& mesh,
                                               const Options& options, render::Camera camera) {
  const OffscreenTarget target(options.size, options.size);
  const GLuint framebuffer = target.framebuffer();
  render::RenderSettings settings;
  settings.isosurfaces = {{options.isovalue, {0.85f, 0.8f, 0.7f}, 1}};
  settings.eye_dome = 0;
  std::array<Times, 5> sums;
  for (int view = -1; view < options.views; ++view) {  // the first one warms up
    camera.azimuth = 360.0 * view / options.views;
    for (size_t kind = 0; kind < sums.size(); ++kind) {
      if (kind != kMesh && !options.kind.empty() && options.kind != kNames[kind]) continue;
      render::Renderer& renderer = kind == kMesh ? mesh : splats;
      settings.kind = kind == kMesh ? render::SplatKind::quad
                                    : static_cast<render::SplatKind>(std::min<size_t>(kind, 2));
      settings.shading =
          kind == 3 || options.smooth ? render::Shading::smooth : render::Shading::exact;
      renderer.set_settings(settings);
      renderer.set_camera(camera);
      auto times = time_frame(renderer, options.size, framebuffer, options.still && kind != kMesh);
      if (!times) return std::nullopt;
      if (options.stages && !time_stages(renderer, options.size, framebuffer, *times)) {
        return std::nullopt;
      }
      if (view >= 0) sums[kind].add(*times);
    }
  }
  return sums;
}

/// Prints a row of Markdown for each kind, in ms of processor time per frame. The remainder is the
/// rasterization of points or triangles, and their fragment shaders.
void print_stages(const std::array<Times, 5>& sums, int views) {
  const Times& empty = sums[0];  // the mesh is lit as quads are, and draws into the same picture
  std::printf(
      "| kind | samples | vertices | points, fragments | picture | frame | of the mesh |\n");
  std::printf("|---|---|---|---|---|---|---|\n");
  for (size_t kind = 0; kind < sums.size(); ++kind) {
    const Times& sum = sums[kind];
    const double picture = kind == kMesh ? empty.picture : sum.picture;
    const auto ms = [views](double seconds) { return seconds / views * 1000; };
    std::printf("| %s | %llu | %.1f | %.1f | %.1f | %.1f | %.2f |\n", kNames[kind],
                static_cast<unsigned long long>(sum.samples / static_cast<uint64_t>(views)),
                ms(sum.vertices), ms(sum.processor - sum.vertices - picture), ms(picture),
                ms(sum.processor), sum.processor / sums[kMesh].processor);
  }
}

int run(int argc, char** argv) {
  if (argc < 4) {
    std::fprintf(stderr, "usage: isosplat_frame_rate VOLUME ISOVALUE MESH [--size PX]\n");
    return 2;
  }
  const Options options = parse_options(argc, argv);
  const TestVolume volume = load_volume(argv[1]);
  const auto context = EglContext::create();
  auto created = context
                     ? render::Renderer::create()
                     : Result<std::unique_ptr<render::Renderer>>(tl::unexpected(context.error()));
  // The mesh has a separate renderer, so that switching costs nothing.
  auto other = created ? render::Renderer::create()
                       : Result<std::unique_ptr<render::Renderer>>(tl::unexpected(created.error()));
  if (!other) {
    std::fprintf(stderr, "%s\n", other.error().message.c_str());
    return 1;
  }
  render::Renderer &splats = **created, &mesh = **other;
  const uint64_t samples = show_volume(splats, volume, options.low, options.high);
  mesh.set_volume(volume.grid, volume.mapping);
  const uint64_t triangles = show_mesh(mesh, volume.grid, argv[3]);
  render::Camera camera = render::default_camera(volume.grid);
  camera.distance *= 0.7;
  const double degree = std::acos(-1.0) / 180;
  const double half = std::tan(camera.field_of_view / 2 * degree) / options.close_up;
  camera.field_of_view = 2 * std::atan(half) / degree;
  const auto times = draw_views(splats, mesh, options, camera);
  if (!times) return 1;
  if (options.stages) {
    print_stages(*times, options.views);
    return 0;
  }
  std::printf("{\"renderer\":\"%s\",\"samples\":%llu,\"triangles\":%llu",
              splats.limits().renderer.c_str(), static_cast<unsigned long long>(samples),
              static_cast<unsigned long long>(triangles));
  for (size_t kind = 0; kind < times->size(); ++kind) {
    const Times& sum = (*times)[kind];
    std::printf(",\"%s_ms\":%.3f,\"%s_cpu_ms\":%.3f", kNames[kind], sum.wall / options.views * 1000,
                kNames[kind], sum.processor / options.views * 1000);
  }
  std::printf("}\n");
  return 0;
}

}  // namespace
}  // namespace isosplat

int main(int argc, char** argv) {
  return isosplat::run(argc, argv);
}
