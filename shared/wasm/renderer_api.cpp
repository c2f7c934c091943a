#include "shared/wasm/renderer_api.h"

#include <emscripten/html5.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "shared/render/colour_maps.h"
#include "shared/render/renderer.h"

using namespace isosplat;

namespace {

/// The module's one view: JavaScript has one module instance for each canvas.
struct View {
  EMSCRIPTEN_WEBGL_CONTEXT_HANDLE context = 0;
  std::unique_ptr<Renderer> renderer;
  RenderSettings settings;
  VolumeGrid grid{{2, 2, 2}};
  std::string text;  // what a const char* of ours points to
  std::vector<DrawnChunk> visible;
  std::vector<uint32_t> occlusion_answer;
};

View& view() {
  static View instance;
  return instance;
}

int32_t report(const Error& error) {
  view().text = error.message;
  return static_cast<int32_t>(error.status);
}

int32_t no_view() {
  return report({Status::invalid_argument, "no view has been created on a canvas yet"});
}

/// The renderer with its context current; null before isosplat_renderer_create.
Renderer* current() {
  View& v = view();
  if (v.renderer) emscripten_webgl_make_context_current(v.context);
  return v.renderer.get();
}

/// Hands a frame's statistics to JavaScript, see isosplat_renderer_draw.
int32_t tell(const Result<FrameStatistics>& drawn, double* statistics) {
  if (!drawn) return report(drawn.error());
  if (statistics) {
    const double numbers[8] = {double(drawn->samples_drawn), double(drawn->samples_resident),
                               double(drawn->gpu_bytes),     double(drawn->chunks_drawn),
                               double(drawn->chunks_culled), double(drawn->draw_calls),
                               double(drawn->kind),          double(drawn->programs_linked)};
    std::copy_n(numbers, 8, statistics);
  }
  return 0;
}

Camera read_camera(const double* c) {
  Camera camera;
  camera.target = {c[0], c[1], c[2]};
  camera.distance = c[3];
  camera.azimuth = c[4];
  camera.elevation = c[5];
  camera.roll = c[6];
  camera.field_of_view = c[7];
  return camera;
}

void write_camera(const Camera& camera, double* c) {
  const double numbers[8] = {camera.target.x, camera.target.y,     camera.target.z,
                             camera.distance, camera.azimuth,      camera.elevation,
                             camera.roll,     camera.field_of_view};
  std::copy_n(numbers, 8, c);
}

/// A context offers what was asked for since it was made or restored, and nothing else.
void enable_extensions() {
  for (const char* extension : {"EXT_color_buffer_float", "EXT_float_blend",
                                "KHR_parallel_shader_compile", "WEBGL_multi_draw"}) {
    emscripten_webgl_enable_extension(view().context, extension);
  }
}

void apply_settings() {
  if (view().renderer) view().renderer->set_settings(view().settings);
}

}  // namespace

int32_t isosplat_renderer_create(const char* canvas_selector) {
  View& v = view();
  isosplat_renderer_destroy();
  EmscriptenWebGLContextAttributes attributes;
  emscripten_webgl_init_context_attributes(&attributes);
  attributes.majorVersion = 2;
  attributes.minorVersion = 0;
  attributes.alpha = true;
  attributes.premultipliedAlpha = true;
  attributes.antialias = false;
  attributes.depth = attributes.stencil = false;
  attributes.powerPreference = EM_WEBGL_POWER_PREFERENCE_HIGH_PERFORMANCE;
  attributes.enableExtensionsByDefault = false;
  v.context = emscripten_webgl_create_context(canvas_selector, &attributes);
  if (v.context <= 0) {
    v.context = 0;
    return report({Status::gl_error,
                   "this browser gives no WebGL 2 context: switch on hardware acceleration, or use "
                   "a current browser"});
  }
  emscripten_webgl_make_context_current(v.context);
  enable_extensions();
  auto renderer = Renderer::create();
  if (!renderer) {
    emscripten_webgl_destroy_context(v.context);
    v.context = 0;
    return report(renderer.error());
  }
  v.renderer = std::move(*renderer);
  apply_settings();
  return 0;
}

void isosplat_renderer_destroy() {
  View& v = view();
  if (!current()) return;
  v.renderer.reset();
  emscripten_webgl_destroy_context(v.context);
  v.context = 0;
}

int32_t isosplat_renderer_is_compiled() {
  const Renderer* renderer = current();
  return !renderer || renderer->is_compiled();
}

int32_t isosplat_renderer_warm_up() {
  Renderer* renderer = current();
  if (!renderer) return no_view();
  const auto done = renderer->warm_up();
  return done ? 0 : report(done.error());
}

const char* isosplat_renderer_error() {
  return view().text.c_str();
}

int32_t isosplat_renderer_set_volume(const double* g, const double* mapping) {
  Renderer* renderer = current();
  if (!renderer) return no_view();
  for (int i = 0; i < 3; ++i) {
    if (!(g[i] >= 2 && g[i] <= kMaxVoxelsPerAxis) || !(g[3 + i] > 0)) {
      return report({Status::invalid_argument,
                     "a volume needs 2 to 1048576 voxels along each axis, and spacings above 0"});
    }
  }
  VolumeGrid grid;
  std::copy_n(g + 9, 9, grid.direction.begin());
  if (!is_basis(grid.direction)) {
    return report({Status::invalid_argument,
                   "a volume's direction needs columns of length 1 that do not lie in a plane"});
  }
  grid.voxels = {static_cast<int32_t>(g[0]), static_cast<int32_t>(g[1]),
                 static_cast<int32_t>(g[2])};
  grid.spacing = {g[3], g[4], g[5]};
  grid.origin = {g[6], g[7], g[8]};
  ValueMapping values;
  values.offset = mapping[0];
  values.scale = mapping[1];
  view().grid = grid;
  renderer->set_volume(grid, values);
  return 0;
}

int32_t isosplat_renderer_add_chunk(uint32_t id, uint32_t level, int32_t block_x, int32_t block_y,
                                    int32_t block_z, const void* samples, uint32_t count) {
  Renderer* renderer = current();
  if (!renderer) return no_view();
  const auto added = renderer->add_chunk(id, {{level, {block_x, block_y, block_z}}},
                                         {static_cast<const PackedSample*>(samples), count});
  return added ? 0 : report(added.error());
}

int32_t isosplat_renderer_check_gpu() {
  const Renderer* renderer = current();
  if (!renderer) return no_view();
  const auto checked = renderer->check_gpu();
  return checked ? 0 : report(checked.error());
}

void isosplat_renderer_remove_chunk(uint32_t id) {
  if (Renderer* renderer = current()) renderer->remove_chunk(id);
}

void isosplat_renderer_set_visible(const uint32_t* ids, const uint32_t* regions, uint32_t count) {
  View& v = view();
  v.visible.resize(count);
  for (uint32_t i = 0; i < count; ++i) {
    v.visible[i] = {ids[i]};
    if (regions) v.visible[i].regions = RegionMask::from_words(regions + 16 * i);
  }
  if (v.renderer) v.renderer->set_visible(std::span<const DrawnChunk>(v.visible));
}

void isosplat_renderer_set_isosurfaces(const double* surfaces, uint32_t count) {
  auto& list = view().settings.isosurfaces;
  list.clear();
  for (uint32_t i = 0; i < count && i < kMaxIsosurfaces; ++i) {
    const double* s = surfaces + 5 * i;
    list.push_back({s[0],
                    {static_cast<float>(s[1]), static_cast<float>(s[2]), static_cast<float>(s[3])},
                    static_cast<float>(s[4])});
  }
  apply_settings();
}

void isosplat_renderer_set_kind(int32_t kind) {
  view().settings.kind = static_cast<SplatKind>(std::clamp(kind, 0, 3));
  apply_settings();
}

void isosplat_renderer_set_colouring(int32_t colour_by, int32_t colour_map, double low,
                                     double high) {
  RenderSettings& settings = view().settings;
  settings.colour_by = static_cast<ColourBy>(std::clamp(colour_by, 0, 5));
  settings.colour_map = static_cast<ColourMap>(std::clamp(colour_map, 0, kColourMaps - 1));
  settings.colour_low = low;
  settings.colour_high = high;
  apply_settings();
}

const uint8_t* isosplat_renderer_colour_map(int32_t colour_map) {
  if (colour_map < 0 || colour_map >= kColourMaps) return nullptr;
  return &kColourMapTable[colour_map][0][0];
}

void isosplat_renderer_set_background(float red, float green, float blue, float alpha) {
  view().settings.background = {red, green, blue, alpha};
  apply_settings();
}

void isosplat_renderer_set_lighting(float ambient, float specular, float eye_dome) {
  RenderSettings& settings = view().settings;
  settings.ambient = ambient;
  settings.specular = specular;
  settings.eye_dome = eye_dome;
  apply_settings();
}

void isosplat_renderer_set_clipping(const double* box, const double* planes, uint32_t count) {
  RenderSettings& settings = view().settings;
  settings.clip_box_low = {box[0], box[1], box[2]};
  settings.clip_box_high = {box[3], box[4], box[5]};
  settings.clip_planes.clear();
  for (uint32_t i = 0; i < count && i < kMaxClipPlanes; ++i) {
    const double* p = planes + 4 * i;
    settings.clip_planes.push_back({{p[0], p[1], p[2]}, p[3]});
  }
  apply_settings();
}

void isosplat_renderer_set_camera(const double* camera) {
  if (view().renderer) view().renderer->set_camera(read_camera(camera));
}

void isosplat_renderer_default_camera(double* camera, double aspect) {
  write_camera(default_camera(view().grid, aspect), camera);
}

void isosplat_renderer_orbit(double* camera, double right_degrees, double up_degrees) {
  write_camera(orbited(read_camera(camera), right_degrees, up_degrees), camera);
}

void isosplat_renderer_pan(double* camera, double right_px, double down_px,
                           double image_height_px) {
  write_camera(panned(read_camera(camera), right_px, down_px, image_height_px), camera);
}

void isosplat_renderer_zoom(double* camera, double factor) {
  write_camera(zoomed(read_camera(camera), factor, bounding_sphere(view().grid).radius), camera);
}

void isosplat_renderer_bound(double* camera) {
  write_camera(bounded(read_camera(camera), view().grid), camera);
}

void isosplat_renderer_projection(const double* camera, int32_t width, int32_t height,
                                  double* clip_from_world) {
  const Projection projected = projection(read_camera(camera), bounding_sphere(view().grid),
                                          {0, 0, 0}, std::max(width, 1), std::max(height, 1));
  std::copy(projected.clip_from_world.begin(), projected.clip_from_world.end(), clip_from_world);
}

int32_t isosplat_renderer_needs_redraw(int32_t width, int32_t height) {
  return view().renderer && view().renderer->needs_redraw(width, height);
}

int32_t isosplat_renderer_draw(int32_t width, int32_t height, double* statistics) {
  Renderer* renderer = current();
  return renderer ? tell(renderer->draw(width, height), statistics) : no_view();
}

int32_t isosplat_renderer_can_refine(int32_t width, int32_t height) {
  return view().renderer && view().renderer->can_refine(width, height);
}

int32_t isosplat_renderer_refine(int32_t width, int32_t height, double* statistics) {
  Renderer* renderer = current();
  return renderer ? tell(renderer->refine(width, height), statistics) : no_view();
}

int32_t isosplat_renderer_hold_picture() {
  Renderer* renderer = current();
  if (!renderer) return no_view();
  const auto held = renderer->hold_picture();
  return held ? 0 : report(held.error());
}

int32_t isosplat_renderer_begin_fade() {
  Renderer* renderer = current();
  if (!renderer) return -no_view();
  const auto begun = renderer->begin_fade();
  return begun ? (*begun ? 1 : 0) : -report(begun.error());
}

int32_t isosplat_renderer_fade(float progress) {
  Renderer* renderer = current();
  if (!renderer) return no_view();
  const auto faded = renderer->fade(progress);
  return faded ? 0 : report(faded.error());
}

int32_t isosplat_renderer_begin_occlusion_query(const uint32_t* ids, uint32_t count,
                                                int32_t min_px) {
  Renderer* renderer = current();
  if (!renderer) return no_view();
  const auto begun =
      renderer->begin_occlusion_query(std::span<const ChunkHandle>(ids, count), min_px);
  return begun ? 0 : report(begun.error());
}

int32_t isosplat_renderer_take_occlusion_query() {
  Renderer* renderer = current();
  if (!renderer) return -1;
  const auto answer = renderer->take_occlusion_query();
  if (!answer) return -1;
  auto& words = view().occlusion_answer;
  words.clear();
  for (const ChunkVisibility& chunk : *answer) {
    words.push_back(chunk.handle);
    for (const RegionMask& mask : {chunk.tested, chunk.visible}) {
      const auto regions = mask.words();
      words.insert(words.end(), regions.begin(), regions.end());
    }
  }
  return static_cast<int32_t>(answer->size());
}

const uint32_t* isosplat_renderer_occlusion_answer() {
  return view().occlusion_answer.data();
}

const char* isosplat_renderer_limits(double* limits) {
  View& v = view();
  v.text.clear();
  if (!v.renderer) return v.text.c_str();
  const RendererLimits& offered = v.renderer->limits();
  limits[0] = double(offered.max_point_size);
  limits[1] = offered.max_texture_size;
  limits[2] = offered.float_targets;
  limits[3] = offered.float_blend;
  v.text = offered.renderer;
  return v.text.c_str();
}

void isosplat_renderer_context_lost() {
  if (view().renderer) view().renderer->context_lost();
}

int32_t isosplat_renderer_context_restored() {
  Renderer* renderer = current();
  if (!renderer) return no_view();
  enable_extensions();
  const auto restored = renderer->context_restored();
  return restored ? 0 : report(restored.error());
}
