// How fast each kind draws, beside a triangle mesh in the same renderer: views around the volume as
// in the paper's experiment (section 6), the kinds in turn at each view.
// isosplat_frame_rate VOLUME ISOVALUE MESH [--size PX] [--views N] [--kind K] [--band LOW HIGH]
// Prints one line of JSON. --band: samples active anywhere in this range are resident, as chunks
// hold them; without it, just the active ones.
#include <GLES3/gl3.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>

#include "native/headless/egl_context.h"
#include "tests/bench/render/volume.h"

namespace isosplat {
namespace {

int run(int argc, char** argv) {
  if (argc < 4) {
    std::fprintf(stderr, "usage: isosplat_frame_rate VOLUME ISOVALUE MESH [--size PX]\n");
    return 2;
  }
  const double isovalue = std::atof(argv[2]);
  int size = 1024, views = 36;
  double low = isovalue, high = isovalue;
  std::string only;
  for (int i = 4; i < argc; ++i) {
    const auto next = [&] { return i + 1 < argc ? argv[++i] : "0"; };
    if (!std::strcmp(argv[i], "--size"))
      size = std::atoi(next());
    else if (!std::strcmp(argv[i], "--views"))
      views = std::max(1, std::atoi(next()));
    else if (!std::strcmp(argv[i], "--kind"))
      only = next();
    else if (!std::strcmp(argv[i], "--band")) {
      low = std::atof(next());
      high = std::atof(next());
    }
  }
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
  const uint64_t samples = show_volume(splats, volume, low, high);
  mesh.set_volume(volume.grid, volume.mapping);
  const uint64_t triangles = show_mesh(mesh, volume.grid, argv[3]);

  GLuint framebuffer = 0, colour = 0;
  glGenFramebuffers(1, &framebuffer);
  glGenRenderbuffers(1, &colour);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  glBindRenderbuffer(GL_RENDERBUFFER, colour);
  glRenderbufferStorage(GL_RENDERBUFFER, GL_RGBA8, size, size);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, colour);

  RenderSettings settings;
  settings.isosurfaces = {{isovalue, {0.85f, 0.8f, 0.7f}, 1}};
  settings.eye_dome = 0;
  constexpr const char* kNames[] = {"quad", "ellipse", "blended", "exact", "mesh"};
  double seconds[5] = {0, 0, 0, 0, 0}, processor_seconds[5] = {0, 0, 0, 0, 0};
  Camera camera = default_camera(volume.grid);
  camera.distance *= 0.7;
  for (int view = -1; view < views; ++view) {  // the first one warms up
    camera.azimuth = 360.0 * view / views;
    for (int kind = 0; kind < 5; ++kind) {
      if (kind < 4 && !only.empty() && only != kNames[kind]) continue;
      Renderer& renderer = kind == 4 ? mesh : splats;
      settings.kind = static_cast<SplatKind>(kind % 4);
      renderer.set_settings(settings);
      renderer.set_camera(camera);
      glFinish();
      const auto begin = std::chrono::steady_clock::now();
      const std::clock_t processor_begin = std::clock();
      if (!renderer.draw(size, size, framebuffer)) return 1;
      glFinish();
      const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - begin;
      if (view < 0) continue;
      seconds[kind] += taken.count();
      processor_seconds[kind] += double(std::clock() - processor_begin) / CLOCKS_PER_SEC;
    }
  }
  std::printf("{\"renderer\":\"%s\",\"samples\":%llu,\"triangles\":%llu",
              splats.limits().renderer.c_str(), static_cast<unsigned long long>(samples),
              static_cast<unsigned long long>(triangles));
  for (int kind = 0; kind < 5; ++kind) {
    std::printf(",\"%s_ms\":%.3f,\"%s_cpu_ms\":%.3f", kNames[kind], seconds[kind] / views * 1000,
                kNames[kind], processor_seconds[kind] / views * 1000);
  }
  std::printf("}\n");
  return 0;
}

}  // namespace
}  // namespace isosplat

int main(int argc, char** argv) {
  return isosplat::run(argc, argv);
}
