// Measures the smoothness and the accuracy of normals in close-ups of a store's level 0.
// isosplat_normals STORE VOLUME ISOVALUE [--px PX_PER_CELL]. Prints a line of JSON. Angles are
// those between a normal and the gradient, which is computed by central differences at the voxels
// and interpolated trilinearly. Jumps are measured on four adjacent pixels of a surface, of which
// two are in one cell and two in the next: a jump is the angle between the middle two, minus the
// larger of the other two angles. Jumps are listed by the kind of border between the cells. Depths
// of adjacent pixels differ by at most two pixels, which excludes coarse and fine surfaces that do
// not meet.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "native/headless/draw_image.h"
#include "native/headless/egl_context.h"
#include "native/headless/store_scene.h"
#include "tests/bench/need.h"
#include "tests/bench/render/reference_normals.h"
#include "tests/bench/render/volume.h"

namespace isosplat {
namespace {

constexpr int kSize = 384;

struct Pixel {
  bool hit = false;
  Vec3d index, normal;  // in voxels; in the world
  double depth = 0;
};

std::vector<Pixel> draw(render::Renderer& renderer, const VolumeGrid& grid,
                        const render::Camera& camera) {
  renderer.set_camera(camera);
  need(draw_image(renderer, kSize, kSize));
  const auto pixels = need(renderer.read_surface());
  const render::CameraFrame frame = render::camera_frame(camera);
  const Matrix3d dual = grid.dual_edges();
  std::vector<Pixel> result(pixels.size());
  for (size_t i = 0; i < pixels.size(); ++i) {
    const auto& from = pixels[i];
    if (!from.hit) continue;
    const auto across = [&](size_t at) {
      return (double(at) + 0.5 - 0.5 * kSize) * 2 * frame.tan_half_field_of_view / kSize;
    };
    const Vec3d ray =
        frame.forward + frame.right * across(i % kSize) + frame.up * across(i / kSize);
    const Vec3d position = frame.eye + ray * double(from.depth);
    result[i] = {true, multiply_transposed(dual, position - grid.origin),
                 frame.right * double(from.normal.x) + frame.up * double(from.normal.y) -
                     frame.forward * double(from.normal.z),
                 double(from.depth)};
  }
  return result;
}

/// The measurements with one shading, in all views.
struct Measured {
  std::vector<double> angles, cells, blocks, levels;
};

/// is_coarse: whether cells of level 1 are drawn there, in blocks of level 0.
template <class IsCoarse>
void add_jumps(const std::vector<Pixel>& pixels, double depth_step, IsCoarse is_coarse,
               Measured& measured) {
  const auto cell = [&](const Pixel& pixel, double size) {
    const Vec3d p = pixel.index * (1 / size);
    return Vec3d{std::floor(p.x), std::floor(p.y), std::floor(p.z)};
  };
  const auto cell_of_level = [&](const Pixel& pixel) {
    return cell(pixel, is_coarse(cell(pixel, 64)) ? 2 : 1);
  };
  for (size_t i = 0; i < pixels.size(); ++i) {
    for (const size_t by : {size_t{1}, size_t{kSize}}) {
      if (i + 3 * by >= pixels.size() || (by == 1 && i % kSize + 3 >= kSize)) continue;
      const Pixel* p[4];
      for (size_t k = 0; k < 4; ++k) p[k] = &pixels[i + k * by];
      bool is_surface = p[0]->hit;
      for (size_t k = 1; k < 4; ++k) {
        is_surface =
            is_surface && p[k]->hit && std::abs(p[k]->depth - p[k - 1]->depth) < depth_step;
      }
      if (!is_surface) continue;
      if (cell_of_level(*p[0]) != cell_of_level(*p[1]) ||
          cell_of_level(*p[1]) == cell_of_level(*p[2]) ||
          cell_of_level(*p[2]) != cell_of_level(*p[3])) {
        continue;
      }
      const auto step = [&](int k) { return angle(p[k]->normal, p[k + 1]->normal); };
      const double jump = std::max(0.0, step(1) - std::max(step(0), step(2)));
      const Vec3d block = cell(*p[1], 64), next = cell(*p[2], 64);
      const bool levels = is_coarse(block) != is_coarse(next);
      (levels ? measured.levels : block != next ? measured.blocks : measured.cells).push_back(jump);
    }
  }
}

/// Shows the volume with blocks of level 0 and of level 1 in turn, as while a view loads.
void show_levels(render::Renderer& renderer, const TestVolume& volume, double isovalue) {
  const double quantized = volume.mapping.quantized_isovalue(isovalue);
  const LevelGrid fine = level_grid(volume.grid.voxels, 0);
  std::vector<DrawnChunk> drawn;
  const auto add = [&](BlockKey block, const RegionMask& regions) {
    const auto handle = static_cast<ChunkHandle>(drawn.size());
    const auto samples = block_samples(volume, block, quantized, quantized);
    if (!renderer.add_chunk(handle, block, samples)) die("a chunk cannot be added");
    drawn.push_back({handle, regions});
  };
  renderer.set_volume(volume.grid, volume.mapping);
  for (int32_t z = 0; z < fine.blocks.z; ++z) {
    for (int32_t y = 0; y < fine.blocks.y; ++y) {
      for (int32_t x = 0; x < fine.blocks.x; ++x) {
        if ((x + y + z) % 2 == 0) {
          add({0, {x, y, z}}, RegionMask::all());
        } else {
          add({1, {x / 2, y / 2, z / 2}}, RegionMask::of_block_below({x % 2, y % 2, z % 2}, 1));
        }
      }
    }
  }
  renderer.set_visible(drawn);
}

/// Close-ups of points that are seen from two sides. at_borders: only points near the border of a
/// block.
std::vector<render::Camera> close_ups(render::Renderer& renderer, const VolumeGrid& grid,
                                      double px_per_cell, bool at_borders) {
  std::vector<render::Camera> cameras;
  const double cell = std::cbrt(grid.spacing.x * grid.spacing.y * grid.spacing.z);
  for (const double azimuth : {30.0, 200.0}) {
    render::Camera camera = render::default_camera(grid);
    camera.distance *= 0.7;
    camera.azimuth = azimuth;
    const auto pixels = draw(renderer, grid, camera);
    const double focal_px = 0.5 * kSize / render::camera_frame(camera).tan_half_field_of_view;
    size_t found = 0;
    for (size_t i = 0; i < pixels.size() && found < 8; ++i) {
      const size_t at = i * 7919 % pixels.size();  // in an order that covers the image evenly
      if (!pixels[at].hit) continue;
      const auto distance = [](double x) { return std::abs(x - 64 * std::round(x / 64)); };
      const Vec3d p = pixels[at].index;
      if (at_borders && std::min({distance(p.x), distance(p.y), distance(p.z)}) > 2) continue;
      render::Camera close = camera;
      close.target = grid.world(pixels[at].index);
      close.distance = focal_px * cell / px_per_cell;
      cameras.push_back(close);
      ++found;
    }
  }
  return cameras;
}

int run(int argc, char** argv) {
  if (argc < 4) {
    std::fprintf(stderr, "usage: isosplat_normals STORE VOLUME ISOVALUE [--px PX_PER_CELL]\n");
    return 2;
  }
  const double isovalue = std::atof(argv[3]);
  const double px_per_cell = argc > 5 && !std::strcmp(argv[4], "--px") ? std::atof(argv[5]) : 8;
  const auto store = need(StoreFile::open(argv[1]));
  const TestVolume volume = load_volume(argv[2]);
  const VolumeGrid& grid = volume.grid;
  const auto context = need(EglContext::create());
  const auto renderer = need(render::Renderer::create());
  render::RenderSettings settings;
  settings.kind = render::SplatKind::exact;
  settings.isosurfaces = {{isovalue, {1, 1, 1}, 1}};
  renderer->set_settings(settings);

  constexpr const char* kNames[] = {"smooth", "exact"};
  Measured measured[2];
  for (const bool mixed : {false, true}) {
    if (mixed) {
      show_levels(*renderer, volume, isovalue);
    } else {
      need(show_store(*renderer, *store, std::span(&isovalue, 1), 0, ~uint64_t{0}));
    }
    const auto is_coarse = [mixed](Vec3d block) {
      return mixed && static_cast<int64_t>(block.x + block.y + block.z) % 2 != 0;
    };
    for (const render::Camera& camera : close_ups(*renderer, grid, px_per_cell, mixed)) {
      for (const render::Shading shading : {render::Shading::smooth, render::Shading::exact}) {
        settings.shading = shading;
        renderer->set_settings(settings);
        const auto pixels = draw(*renderer, grid, camera);
        const double cell = std::min({grid.spacing.x, grid.spacing.y, grid.spacing.z});
        Measured& found = measured[static_cast<size_t>(shading)];
        Measured ignored;
        add_jumps(pixels, 2 * cell / px_per_cell, is_coarse, mixed ? ignored : found);
        if (mixed) {
          found.levels.insert(found.levels.end(), ignored.levels.begin(), ignored.levels.end());
          continue;
        }
        for (const Pixel& pixel : pixels) {
          if (!pixel.hit) continue;
          found.angles.push_back(angle(pixel.normal, reference_gradient(volume, pixel.index)));
        }
      }
    }
  }
  std::printf("{");
  for (size_t i = 0; i < 2; ++i) {
    Measured& m = measured[i];
    std::printf("%s\"%s\":{\"pixels\":%zu,\"median\":%.4f,\"p95\":%.4f", i ? "," : "", kNames[i],
                m.angles.size(), percentile(m.angles, 0.5), percentile(m.angles, 0.95));
    std::printf(",\"cells\":%.4f,\"blocks\":%.4f,\"levels\":%.4f,\"crossings\":[%zu,%zu,%zu]}",
                percentile(m.cells, 0.95), percentile(m.blocks, 0.95), percentile(m.levels, 0.95),
                m.cells.size(), m.blocks.size(), m.levels.size());
  }
  std::printf("}\n");
  return 0;
}

}  // namespace
}  // namespace isosplat

int main(int argc, char** argv) {
  return isosplat::run(argc, argv);
}
