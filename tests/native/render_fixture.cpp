// Writes the input and the expected pictures of the browser's picture test: samples of a small
// anisotropic and sheared volume, values of a field, and native pictures of every splat kind.
// isosplat_render_fixture FOLDER
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>

#include "native/headless/draw_image.h"
#include "native/headless/egl_context.h"
#include "tests/native/test_volume.h"

using namespace isosplat;
using namespace isosplat::render;

namespace {

template <class T>
void write_file(const std::string& path, const std::vector<T>& items) {
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(items.data()),
             static_cast<std::streamsize>(items.size() * sizeof(T)));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const std::string folder = argv[1];
  const auto context = EglContext::create();
  auto renderer = context ? Renderer::create()
                          : Result<std::unique_ptr<Renderer>>(tl::unexpected(context.error()));
  if (!renderer) {
    std::fprintf(stderr, "%s\n", renderer.error().message.c_str());
    return 1;
  }
  VolumeGrid grid{{60, 50, 30}, {1, 1.25, 2}};
  grid.direction = {1, 0.6, 0, 0, 0.8, 0, 0, 0, 1};
  const Vec3d centre = grid.world({29.5, 24.5, 14.5});
  const TestVolume volume = sampled_volume(grid, [&](Vec3d p) { return 100 * length(p - centre); });
  const auto samples = block_samples(volume, {0, {0, 0, 0}}, 1500, 2500);
  std::vector<PackedSample> ordered;
  const auto clusters = cluster_samples(samples, ordered);
  write_file(folder + "/samples.bin", ordered);
  write_file(folder + "/clusters.bin", clusters);
  TestVolume second = sampled_volume(grid.voxels, grid.spacing, [](Vec3d p) {
    return 1000 + 500 * std::sin(0.3 * p.x) * std::cos(0.2 * p.y + 0.1 * p.z);
  });
  for (size_t i = 0; i < second.quantized_values.size(); i += 60) {
    std::fill_n(second.quantized_values.begin() + long(i), 22, kMissingVoxel);  // x < 22
  }
  std::vector<PackedField> values;
  for (const PackedSample& sample : ordered) {
    const Index3 cell = unpack_sample(sample).cell;
    values.push_back(pack_field(corners_at(second, cell.x, cell.y, cell.z)));
  }
  write_file(folder + "/field.bin", values);
  (*renderer)->set_volume(volume.grid, volume.mapping);
  const ChunkHandle handle = 7;
  if (!(*renderer)->add_chunk(handle, {0, {0, 0, 0}}, samples)) return 1;
  (*renderer)->set_visible({&handle, 1});
  ValueMapping field;
  field.scale = 0.5;
  field.has_missing = true;
  if (!(*renderer)->set_field(field) || !(*renderer)->set_chunk_field(handle, values)) return 1;
  Camera camera = default_camera(volume.grid);
  camera.distance *= 0.6;
  (*renderer)->set_camera(camera);
  RenderSettings settings;
  settings.isosurfaces = {{1500.5, {0.9f, 0.3f, 0.2f}, 1}, {2500, {0.85f, 0.8f, 0.7f}, 0.4f}};
  const std::vector<Isosurface> both = settings.isosurfaces;
  settings.clip_box_high.x = 0.8;
  constexpr SplatKind kKinds[] = {
      SplatKind::quad,  SplatKind::ellipse, SplatKind::exact, SplatKind::exact,  SplatKind::quad,
      SplatKind::exact, SplatKind::exact,   SplatKind::quad,  SplatKind::quad,   SplatKind::ellipse,
      SplatKind::exact, SplatKind::quad,    SplatKind::quad,  SplatKind::quad,   SplatKind::quad,
      SplatKind::exact, SplatKind::quad,    SplatKind::quad,  SplatKind::ellipse};
  for (int kind = 0; kind < 19; ++kind) {
    settings.kind = kKinds[kind];
    settings.shading = kind == 3 ? Shading::exact : Shading::smooth;
    const bool lit_at_once = kind == 4 || kind == 8 || kind == 12 || kind == 14 || kind == 16;
    const bool is_still = kind == 5 || kind == 6;  // with all that accumulates at rest
    settings.clip_caps = kind == 6;
    settings.isosurfaces = both;
    if (lit_at_once) settings.isosurfaces.resize(1);
    settings.eye_dome = lit_at_once ? 0 : RenderSettings{}.eye_dome;
    if (kind >= 9) {
      settings.colour_by = ColourBy::field;
      settings.colour_low = 300;
      settings.colour_high = 700;
      settings.field_scale = kind == 10 ? FieldScale::logarithmic : FieldScale::linear;
      settings.field_steps = kind == 11 ? 6 : 0;
      settings.field_lines = kind >= 15 ? 37 : 0;
      settings.field_missing_colour = {1, 0, 1};
    }
    const bool triangles = kind == 7 || kind == 8 || kind == 13 || kind == 14 || kind == 17;
    Camera near = camera;
    if (triangles) near.distance /= 2;
    (*renderer)->set_camera(near);
    (*renderer)->set_settings(settings);
    const auto image = draw_image(**renderer, 256, 256, nullptr, is_still);
    if (!image) return 1;
    std::ofstream(folder + "/" + std::to_string(kind) + ".rgba", std::ios::binary)
        .write(reinterpret_cast<const char*>(image->rgba.data()),
               static_cast<std::streamsize>(image->rgba.size()));
    if (!write_png(folder + "/" + std::to_string(kind) + ".png", *image)) return 1;
  }
  std::printf("%.17g %.17g %.17g %.17g\n", camera.target.x, camera.target.y, camera.target.z,
              camera.distance);
  return 0;
}
