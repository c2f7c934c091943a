// Errors of the pictures of each splat kind, and of a triangle mesh drawn by the same renderer,
// compared with the ray caster. isosplat_fidelity VOLUME ISOVALUE [--mesh FILE] [--size PX] [--kind
// K] [--view V] [--store STORE --level N] [--pictures FOLDER]. With a level: pictures of that level
// of a store of the volume, compared with the same reference, the surface of level 0. Prints a line
// of JSON for each view and kind.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <thread>

#include "native/headless/draw_image.h"
#include "native/headless/egl_context.h"
#include "native/headless/ray_caster.h"
#include "native/headless/store_scene.h"
#include "tests/bench/render/volume.h"

namespace isosplat {
namespace {

constexpr double kDegrees = 180 / 3.14159265358979323846;

/// The picture of the ray caster.
struct Reference {
  std::vector<std::optional<RayCaster::Hit>> hits;
  std::vector<char> deep;  // a hit at least 2 px from silhouettes and depth edges
  int count = 0;
};

Reference cast_reference(const RayCaster& caster, const render::Camera& camera, int size,
                         double quantized_isovalue, double cell) {
  Reference reference;
  const size_t n = size_t(size);
  reference.hits.resize(n * n);
  const unsigned threads = std::max(1u, std::thread::hardware_concurrency());
  std::vector<std::thread> pool;
  for (unsigned thread = 0; thread < threads; ++thread) {
    pool.emplace_back([&, thread] {
      for (int y = static_cast<int>(thread); y < size; y += static_cast<int>(threads)) {
        for (int x = 0; x < size; ++x) {
          reference.hits[size_t(y) * n + size_t(x)] =
              caster.cast(camera, size, size, x, y, quantized_isovalue);
        }
      }
    });
  }
  for (std::thread& thread : pool) thread.join();

  // A pixel is at an edge if a neighbour is background, or more than two cells nearer or farther.
  std::vector<char> edge(n * n);
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      const size_t i = size_t(y) * n + size_t(x);
      const auto& here = reference.hits[i];
      reference.count += here.has_value();
      if (!here) {
        edge[i] = 1;
        continue;
      }
      const auto check = [&](size_t j) {
        const auto& there = reference.hits[j];
        if (!there || std::abs(there->depth - here->depth) > 2 * cell) edge[i] = 1;
      };
      if (x > 0) check(i - 1);
      if (x + 1 < size) check(i + 1);
      if (y > 0) check(i - n);
      if (y + 1 < size) check(i + n);
    }
  }
  reference.deep.assign(n * n, 0);
  for (int y = 2; y < size - 2; ++y) {
    for (int x = 2; x < size - 2; ++x) {
      bool deep = true;
      for (int j = -2; j <= 2; ++j) {
        for (int i = -2; i <= 2; ++i) {
          deep = deep && !edge[size_t(y + j) * n + size_t(x + i)];
        }
      }
      reference.deep[size_t(y) * n + size_t(x)] = deep;
    }
  }
  return reference;
}

/// Colours of the picture of differences. kExcess: only the renderer has a surface; kMissed: only
/// the reference does.
constexpr std::array<uint8_t, 4> kBoth{200, 200, 200, 255}, kExcess{220, 0, 0, 255},
    kMissed{0, 0, 220, 255}, kHole{0, 160, 0, 255}, kNeither{255, 255, 255, 255};

void compare(render::Renderer& renderer, const Reference& reference, double cell, const char* view,
             const char* kind, const render::FrameStatistics& statistics, Image& difference) {
  const auto pixels = renderer.read_surface();
  if (!pixels) return;
  const render::CameraFrame frame = render::camera_frame(renderer.camera());
  double depth = 0, depth_all = 0, normal = 0;
  int holes = 0, missed = 0, excess = 0, both = 0, deep = 0;
  for (size_t i = 0; i < pixels->size(); ++i) {
    const auto& truth = reference.hits[i];
    const auto& ours = (*pixels)[i];
    const bool covered = ours.hit;
    const auto mark = [&](const std::array<uint8_t, 4>& colour) {
      const size_t width = size_t(difference.width), row = pixels->size() / width - 1 - i / width;
      std::copy_n(colour.begin(), 4, &difference.rgba[4 * (row * width + i % width)]);
    };
    mark(truth ? covered ? kBoth : kMissed : covered ? kExcess : kNeither);
    missed += truth && !covered;
    excess += !truth && covered;
    const double error = truth && covered ? std::abs(double(ours.depth) - truth->depth) / cell : 0;
    if (truth && covered) {
      ++both;
      depth_all += std::min(error, 10.0);
    }
    if (!reference.deep[i]) continue;
    if (!covered || (double(ours.depth) - truth->depth) / cell > 2) {
      ++holes;
      mark(kHole);
      continue;
    }
    ++deep;
    depth += error;
    const Vec3d n = frame.right * double(ours.normal.x) + frame.up * double(ours.normal.y) -
                    frame.forward * double(ours.normal.z);
    if (truth->gradient > 0) {
      normal += std::acos(std::min(1.0, std::abs(dot(n, truth->normal)))) * kDegrees;
    }
  }
  std::printf(
      "{\"view\":\"%s\",\"kind\":\"%s\",\"reference\":%d,\"deep\":%d,\"holes\":%d,"
      "\"missed\":%d,\"excess\":%d,\"silhouette\":%.6f,\"depth\":%.6f,\"depth_all\":%.6f,"
      "\"normal\":%.5f,\"samples\":%llu}\n",
      view, kind, reference.count, deep, holes, missed, excess,
      double(missed + excess) / std::max(1, reference.count), depth / std::max(1, deep),
      depth_all / std::max(1, both), normal / std::max(1, deep),
      static_cast<unsigned long long>(statistics.samples_drawn));
  std::fflush(stdout);
}

struct Options {
  std::string mesh, pictures, kind, view, store;  ///< empty: none, or all
  uint32_t level = 0;                             ///< of the store
  int size = 1024;
  Displaced displaced = Displaced::clamp;
  float scale = 1;
};

Options parse_options(int argc, char** argv) {
  Options options;
  for (int i = 3; i < argc; ++i) {
    const auto next = [&] { return i + 1 < argc ? argv[++i] : ""; };
    if (!std::strcmp(argv[i], "--mesh"))
      options.mesh = next();
    else if (!std::strcmp(argv[i], "--size"))
      options.size = std::atoi(next());
    else if (!std::strcmp(argv[i], "--pictures"))
      options.pictures = next();
    else if (!std::strcmp(argv[i], "--kind"))
      options.kind = next();
    else if (!std::strcmp(argv[i], "--view"))
      options.view = next();
    else if (!std::strcmp(argv[i], "--store"))
      options.store = next();
    else if (!std::strcmp(argv[i], "--level"))
      options.level = static_cast<uint32_t>(std::atoi(next()));
    else if (!std::strcmp(argv[i], "--scale"))
      options.scale = static_cast<float>(std::atof(next()));
    else if (!std::strcmp(argv[i], "--drop"))
      options.displaced = Displaced::drop;
  }
  return options;
}

/// The volume with its reference, and the isovalue to compare.
struct Subject {
  TestVolume volume;
  RayCaster caster;
  double isovalue, quantized_isovalue;
  double cell;  ///< smallest spacing

  Subject(const char* path, double value)
      : volume(load_volume(path)),
        caster(volume.grid, volume.quantized_values, volume.mapping.has_missing),
        isovalue(value),
        quantized_isovalue((value - volume.mapping.offset) / volume.mapping.scale),
        cell(std::min({volume.grid.spacing.x, volume.grid.spacing.y, volume.grid.spacing.z})) {}
};

/// A camera so near to the surface, close to the centre of the picture, that a cell covers about 20
/// pixels. The same camera if the surface is not found.
render::Camera close_camera(const Subject& subject, const render::Camera& camera, int size) {
  render::Camera close = camera;
  for (int ring = 0; ring < size / 2; ring += 8) {
    for (int turn = 0; turn < 8; ++turn) {
      const double angle = turn * 0.785398;
      const double right = ring * std::cos(angle), up = ring * std::sin(angle);
      const int x = size / 2 + static_cast<int>(right), y = size / 2 + static_cast<int>(up);
      const auto hit = subject.caster.cast(camera, size, size, x, y, subject.quantized_isovalue);
      if (!hit) continue;
      const render::CameraFrame frame = render::camera_frame(camera);
      const double px = 2 * frame.tan_half_field_of_view / size;
      close.target =
          frame.eye +
          (frame.forward + frame.right * (px * right) + frame.up * (px * up)) * hit->depth;
      close.distance = subject.cell * size / (2 * frame.tan_half_field_of_view) / 20;
      return close;
    }
  }
  return close;
}

/// Compares the pictures of all kinds from one camera. Exits if one cannot be drawn.
void compare_view(render::Renderer& renderer, const Subject& subject, const char* view,
                  const render::Camera& camera, const Options& options) {
  const int size = options.size;
  renderer.set_camera(camera);
  const Reference reference =
      cast_reference(subject.caster, camera, size, subject.quantized_isovalue, subject.cell);
  render::RenderSettings settings;
  settings.isosurfaces = {{subject.isovalue, {0.85f, 0.8f, 0.7f}, 1}};
  settings.splat_scale = options.scale;
  settings.displaced = options.displaced;
  const auto draw = [&](const char* kind) {
    if (!options.kind.empty() && options.kind != kind) return;
    renderer.set_settings(settings);
    render::FrameStatistics statistics;
    const auto image = draw_image(renderer, size, size, &statistics);
    if (!image) {
      std::fprintf(stderr, "%s\n", image.error().message.c_str());
      std::exit(1);
    }
    Image difference = *image;
    compare(renderer, reference, subject.cell, view, kind, statistics, difference);
    if (options.pictures.empty()) return;
    const std::string path = options.pictures + "/" + view + "-" + kind;
    (void)write_png(path + ".png", *image);
    (void)write_png(path + "-difference.png", difference);
  };
  constexpr const char* kKinds[] = {"quad", "ellipse", "exact"};
  settings.shading = render::Shading::exact;  // the reference has each cell's own gradient
  for (int kind = 0; kind < 3; ++kind) {
    settings.kind = static_cast<render::SplatKind>(kind);
    draw(kKinds[kind]);
  }
  if (!options.mesh.empty()) {
    show_mesh(renderer, subject.volume.grid, options.mesh);
    draw("mesh");
    (void)renderer.set_mesh({}, {});
  }
}

/// Shows a level of the store.
Result<StoreScene> show_level(render::Renderer& renderer, const Subject& subject,
                              const Options& options) {
  auto store = StoreFile::open(options.store);
  if (!store) return tl::unexpected(store.error());
  return show_store(renderer, **store, std::span(&subject.isovalue, 1), options.level,
                    ~uint64_t{0});
}

int run(int argc, char** argv) {
  if (argc < 3) {
    std::fprintf(stderr, "usage: isosplat_fidelity VOLUME ISOVALUE [--mesh FILE] [--size PX]\n");
    return 2;
  }
  const Options options = parse_options(argc, argv);
  const Subject subject(argv[1], std::atof(argv[2]));
  const auto context = EglContext::create();
  auto created = context
                     ? render::Renderer::create()
                     : Result<std::unique_ptr<render::Renderer>>(tl::unexpected(context.error()));
  if (!created) {
    std::fprintf(stderr, "%s\n", created.error().message.c_str());
    return 1;
  }
  render::Renderer& renderer = **created;
  if (options.store.empty()) {
    show_volume(renderer, subject.volume, subject.isovalue, subject.isovalue);
  } else if (const auto shown = show_level(renderer, subject, options); !shown) {
    std::fprintf(stderr, "%s\n", shown.error().message.c_str());
    return 1;
  }

  render::Camera front = render::default_camera(subject.volume.grid);
  front.distance *= 0.7;
  render::Camera back = front;
  back.azimuth = 160;
  back.elevation = -25;
  const std::pair<const char*, render::Camera> views[] = {
      {"front", front}, {"back", back}, {"close", close_camera(subject, front, options.size)}};
  for (const auto& [name, camera] : views) {
    if (!options.view.empty() && options.view != name) continue;
    compare_view(renderer, subject, name, camera, options);
  }
  return 0;
}

}  // namespace
}  // namespace isosplat

int main(int argc, char** argv) {
  return isosplat::run(argc, argv);
}
