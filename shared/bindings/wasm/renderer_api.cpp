#include "shared/bindings/wasm/renderer_api.h"

#include <emscripten/html5.h>

#include <algorithm>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "shared/render/renderer.h"
#include "shared/render/settings/colour_maps.h"

using namespace isosplat;
using namespace isosplat::render;

namespace {

/// The state of the module: JavaScript creates one instance of the module per canvas. Volume,
/// settings and camera are the renderer's.
struct State {
  EMSCRIPTEN_WEBGL_CONTEXT_HANDLE context = 0;
  std::unique_ptr<Renderer> renderer;
  std::string error;
  std::vector<IsosplatVisibility> occlusion_answer;
};

State& state() {
  static State instance;
  return instance;
}

constexpr IsosplatStatus kOk = static_cast<IsosplatStatus>(Status::ok);

IsosplatStatus report(const Error& error) {
  state().error = error.message;
  return static_cast<IsosplatStatus>(error.status);
}

template <class T>
IsosplatStatus status_of(const Result<T>& result) {
  return result ? kOk : report(result.error());
}

IsosplatStatus no_renderer() {
  return report({Status::invalid_argument,
                 "no renderer has been created on a canvas yet: call isosplat_renderer_create"});
}

/// The renderer with its context current; null before isosplat_renderer_create.
Renderer* current() {
  State& s = state();
  if (s.renderer) emscripten_webgl_make_context_current(s.context);
  return s.renderer.get();
}

IsosplatStatus report_drawn(const Result<FrameStatistics>& drawn,
                            IsosplatFrameStatistics* statistics) {
  if (!drawn) return report(drawn.error());
  if (!statistics) return kOk;
  *statistics = {};
  statistics->samples_drawn = double(drawn->samples_drawn);
  statistics->samples_resident = double(drawn->samples_resident);
  statistics->gpu_bytes = double(drawn->gpu_bytes);
  statistics->chunks_drawn = drawn->chunks_drawn;
  statistics->chunks_culled = drawn->chunks_culled;
  statistics->draw_calls = drawn->draw_calls;
  statistics->programs_linked = drawn->programs_linked;
  return kOk;
}

Vec3d as_vector(const double* numbers) {
  return {numbers[0], numbers[1], numbers[2]};
}

std::vector<Plane> planes_of(std::span<const IsosplatPlane> records) {
  std::vector<Plane> planes;
  for (const IsosplatPlane& plane : records) {
    planes.push_back({as_vector(plane.normal), plane.offset});
  }
  return planes;
}

Camera read_camera(const IsosplatCamera& record) {
  Camera camera;
  camera.target = as_vector(record.target);
  camera.distance = record.distance;
  camera.azimuth = record.azimuth;
  camera.elevation = record.elevation;
  camera.roll = record.roll;
  camera.field_of_view = record.field_of_view;
  camera.orthographic = record.orthographic != 0;
  return camera;
}

IsosplatCamera record_of(const Camera& camera) {
  return {{camera.target.x, camera.target.y, camera.target.z},
          camera.distance,
          camera.azimuth,
          camera.elevation,
          camera.roll,
          camera.field_of_view,
          camera.orthographic ? 1.0 : 0.0};
}

/// A context, new or restored, offers only the extensions that are enabled on it.
void enable_extensions() {
  for (const char* extension : {"EXT_color_buffer_float", "EXT_float_blend",
                                "KHR_parallel_shader_compile", "WEBGL_multi_draw"}) {
    emscripten_webgl_enable_extension(state().context, extension);
  }
}

/// Changes some of the renderer's settings.
template <class Change>
void change_settings(Change change) {
  if (!state().renderer) return;
  RenderSettings settings = state().renderer->settings();
  change(settings);
  state().renderer->set_settings(settings);
}

/// The renderer's volume.
VolumeGrid grid() {
  return state().renderer ? state().renderer->grid() : VolumeGrid{{2, 2, 2}};
}

}  // namespace

IsosplatStatus isosplat_renderer_create(const char* canvas_selector) {
  State& s = state();
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
  s.context = emscripten_webgl_create_context(canvas_selector, &attributes);
  if (s.context <= 0) {
    s.context = 0;
    return report(
        {Status::gl_error,
         "this browser offers no WebGL 2 context: switch on hardware acceleration, or use "
         "a current browser"});
  }
  emscripten_webgl_make_context_current(s.context);
  enable_extensions();
  auto renderer = Renderer::create();
  if (!renderer) {
    emscripten_webgl_destroy_context(s.context);
    s.context = 0;
    return report(renderer.error());
  }
  s.renderer = std::move(*renderer);
  return kOk;
}

void isosplat_renderer_destroy() {
  State& s = state();
  if (!current()) return;
  s.renderer.reset();
  emscripten_webgl_destroy_context(s.context);
  s.context = 0;
}

bool isosplat_renderer_is_compiled() {
  const Renderer* renderer = current();
  return !renderer || renderer->is_compiled();
}

IsosplatStatus isosplat_renderer_warm_up() {
  Renderer* renderer = current();
  if (!renderer) return no_renderer();
  return status_of(renderer->warm_up());
}

const char* isosplat_renderer_error() {
  return state().error.c_str();
}

IsosplatStatus isosplat_renderer_set_volume(const IsosplatVolume* volume) {
  Renderer* renderer = current();
  if (!renderer) return no_renderer();
  for (int i = 0; i < 3; ++i) {
    const double voxels = volume->voxels[i];
    if (!(voxels >= 2 && voxels <= kMaxVoxelsPerAxis) || !(volume->spacing[i] > 0)) {
      return report({Status::invalid_argument,
                     "a volume needs 2 to 1048576 voxels along each axis, and spacings above 0"});
    }
  }
  VolumeGrid grid;
  std::copy(std::begin(volume->direction), std::end(volume->direction), grid.direction.begin());
  if (!is_basis(grid.direction)) {
    return report({Status::invalid_argument,
                   "a volume's direction needs columns of length 1 that do not lie in a plane"});
  }
  grid.voxels = {static_cast<int32_t>(volume->voxels[0]), static_cast<int32_t>(volume->voxels[1]),
                 static_cast<int32_t>(volume->voxels[2])};
  grid.spacing = as_vector(volume->spacing);
  grid.origin = as_vector(volume->origin);
  ValueMapping values;
  values.offset = volume->value_offset;
  values.scale = volume->value_scale;
  renderer->set_volume(grid, values);
  return kOk;
}

IsosplatStatus isosplat_renderer_reserve_chunk(uint32_t handle, const IsosplatBlock* block,
                                               const void* clusters, uint32_t cluster_bytes,
                                               double* offset) {
  Renderer* renderer = current();
  if (!renderer) return no_renderer();
  const Index3 index{static_cast<int32_t>(block->block[0]), static_cast<int32_t>(block->block[1]),
                     static_cast<int32_t>(block->block[2])};
  const auto* first = static_cast<const SampleCluster*>(clusters);
  const auto reserved = renderer->reserve_chunk(
      handle, {block->level, index}, {first, first + cluster_bytes / sizeof(SampleCluster)});
  if (!reserved) return report(reserved.error());
  *offset = static_cast<double>(*reserved);
  return kOk;
}

IsosplatStatus isosplat_renderer_check_gpu() {
  Renderer* renderer = current();
  return renderer ? status_of(renderer->check_gpu()) : no_renderer();
}

void isosplat_renderer_remove_chunk(uint32_t handle) {
  if (Renderer* renderer = current()) renderer->remove_chunk(handle);
}

void isosplat_renderer_set_visible(const IsosplatDrawnChunk* chunks, uint32_t count) {
  if (!state().renderer) return;
  std::vector<DrawnChunk> visible;
  visible.reserve(count);
  for (const IsosplatDrawnChunk& chunk : std::span(chunks, count)) {
    visible.push_back({chunk.handle, RegionMask::from_words(chunk.regions)});
  }
  state().renderer->set_visible(std::span<const DrawnChunk>(visible));
}

void isosplat_renderer_set_isosurfaces(const IsosplatIsosurface* isosurfaces, uint32_t count) {
  change_settings([&](RenderSettings& settings) {
    settings.isosurfaces.clear();
    for (const IsosplatIsosurface& isosurface :
         std::span(isosurfaces, std::min<uint32_t>(count, kMaxIsosurfaces))) {
      const float* colour = isosurface.colour;
      settings.isosurfaces.push_back(
          {isosurface.isovalue, {colour[0], colour[1], colour[2]}, isosurface.opacity});
    }
  });
}

void isosplat_renderer_set_splats(uint32_t kind, uint32_t shading) {
  constexpr auto kLastKind = static_cast<uint32_t>(SplatKind::exact);
  constexpr auto kLastShading = static_cast<uint32_t>(Shading::exact);
  change_settings([&](RenderSettings& settings) {
    settings.kind = static_cast<SplatKind>(std::min(kind, kLastKind));
    settings.shading = static_cast<Shading>(std::min(shading, kLastShading));
  });
}

void isosplat_renderer_set_appearance(const IsosplatAppearance* appearance) {
  constexpr auto kLast = static_cast<uint32_t>(ColourBy::projection_error);
  change_settings([&](RenderSettings& settings) {
    settings.colour_by = static_cast<ColourBy>(std::min(appearance->colour_by, kLast));
    settings.colour_map =
        static_cast<ColourMap>(std::min<uint32_t>(appearance->colour_map, kColourMaps - 1));
    settings.colour_low = appearance->colour_low;
    settings.colour_high = appearance->colour_high;
    std::copy(std::begin(appearance->background), std::end(appearance->background),
              settings.background.begin());
    settings.eye_dome = appearance->eye_dome;
  });
}

void isosplat_renderer_set_light(const IsosplatLight* light) {
  change_settings([&](RenderSettings& settings) {
    settings.light = {light->azimuth,
                      light->elevation,
                      light->key,
                      light->sky,
                      light->rim,
                      light->highlight,
                      light->roughness,
                      light->occlusion,
                      light->occlusion_radius,
                      light->shadow,
                      light->shadow_softness};
  });
}

const uint8_t* isosplat_renderer_colour_map(uint32_t colour_map) {
  return colour_map < kColourMaps ? &kColourMapTable[colour_map][0][0] : nullptr;
}

void isosplat_renderer_set_clipping(const IsosplatClipBox* box, const IsosplatPlane* planes,
                                    uint32_t count) {
  change_settings([&](RenderSettings& settings) {
    settings.clip_box_low = as_vector(box->low);
    settings.clip_box_high = as_vector(box->high);
    settings.clip_caps = box->caps != 0;
    settings.clip_planes = planes_of(std::span(planes, std::min<uint32_t>(count, kMaxClipPlanes)));
  });
}

void isosplat_renderer_set_slices(const IsosplatPlane* planes, uint32_t count, double low,
                                  double high) {
  change_settings([&](RenderSettings& settings) {
    settings.slice_low = low;
    settings.slice_high = high;
    settings.slices = planes_of(std::span(planes, std::min<uint32_t>(count, kMaxSlices)));
  });
}

void isosplat_renderer_set_camera(const IsosplatCamera* camera) {
  if (state().renderer) state().renderer->set_camera(read_camera(*camera));
}

void isosplat_renderer_default_camera(IsosplatCamera* camera, double aspect) {
  *camera = record_of(default_camera(grid(), aspect, camera->orthographic != 0));
}

void isosplat_renderer_orbit(IsosplatCamera* camera, double right_degrees, double up_degrees) {
  *camera = record_of(orbited(read_camera(*camera), right_degrees, up_degrees));
}

void isosplat_renderer_pan(IsosplatCamera* camera, double right_px, double down_px,
                           double image_height_px) {
  *camera = record_of(panned(read_camera(*camera), right_px, down_px, image_height_px));
}

void isosplat_renderer_zoom(IsosplatCamera* camera, double factor) {
  *camera = record_of(zoomed(read_camera(*camera), factor, bounding_sphere(grid()).radius));
}

void isosplat_renderer_bound(IsosplatCamera* camera) {
  *camera = record_of(bounded(read_camera(*camera), grid()));
}

void isosplat_renderer_projection(const IsosplatCamera* camera, int32_t width, int32_t height,
                                  IsosplatProjection* result) {
  const Projection projected = projection(read_camera(*camera), bounding_sphere(grid()), {0, 0, 0},
                                          std::max(width, 1), std::max(height, 1));
  std::copy(projected.clip_from_world.begin(), projected.clip_from_world.end(),
            result->clip_from_world);
}

IsosplatStatus isosplat_renderer_pick(double x, double y, int32_t width, int32_t height,
                                      IsosplatPick* pick) {
  if (!state().renderer) return no_renderer();
  const auto found = state().renderer->pick(x, y, width, height);
  if (!found) return report(found.error());
  *pick = {};
  if (!*found) return kOk;
  const SurfacePick& p = **found;
  const auto set = [](double* numbers, Vec3d v) {
    numbers[0] = v.x;
    numbers[1] = v.y;
    numbers[2] = v.z;
  };
  set(pick->position, p.position);
  set(pick->voxel, p.voxel);
  set(pick->normal, p.normal);
  pick->gradient = p.gradient;
  pick->to_next = p.to_next;
  pick->isosurface = p.isosurface;
  pick->level = p.level;
  pick->value = p.value;
  pick->found = 1;
  pick->face = p.slice ? 2 : p.cap ? 1 : 0;
  return kOk;
}

bool isosplat_renderer_needs_redraw(int32_t width, int32_t height) {
  return state().renderer && state().renderer->needs_redraw(width, height);
}

IsosplatStatus isosplat_renderer_draw(int32_t width, int32_t height,
                                      IsosplatFrameStatistics* statistics) {
  Renderer* renderer = current();
  return renderer ? report_drawn(renderer->draw(width, height), statistics) : no_renderer();
}

bool isosplat_renderer_prepare_refine() {
  return !state().renderer || state().renderer->prepare_refine();
}

bool isosplat_renderer_can_refine(int32_t width, int32_t height) {
  return state().renderer && state().renderer->can_refine(width, height);
}

IsosplatStatus isosplat_renderer_refine(int32_t width, int32_t height,
                                        IsosplatFrameStatistics* statistics) {
  Renderer* renderer = current();
  return renderer ? report_drawn(renderer->refine(width, height), statistics) : no_renderer();
}

IsosplatStatus isosplat_renderer_draw_still(int32_t width, int32_t height,
                                            IsosplatFrameStatistics* statistics) {
  Renderer* renderer = current();
  return renderer ? report_drawn(renderer->draw_still(width, height), statistics) : no_renderer();
}

IsosplatStatus isosplat_renderer_begin_tiles(int32_t width, int32_t height) {
  Renderer* renderer = current();
  return renderer ? status_of(renderer->begin_tiles(width, height)) : no_renderer();
}

IsosplatStatus isosplat_renderer_draw_tile(int32_t x, int32_t y, int32_t width, int32_t height,
                                           uint8_t* rgba) {
  Renderer* renderer = current();
  if (!renderer) return no_renderer();
  const size_t bytes = 4 * static_cast<size_t>(width) * static_cast<size_t>(height);
  return report_drawn(
      renderer->draw_tile(x, y, width, height, /*smooth=*/true, std::span(rgba, bytes)), nullptr);
}

void isosplat_renderer_end_tiles() {
  if (state().renderer) state().renderer->end_tiles();
}

IsosplatStatus isosplat_renderer_hold_picture() {
  Renderer* renderer = current();
  return renderer ? status_of(renderer->hold_picture()) : no_renderer();
}

IsosplatStatus isosplat_renderer_begin_fade(uint32_t* has_begun) {
  Renderer* renderer = current();
  if (!renderer) return no_renderer();
  const auto begun = renderer->begin_fade();
  if (!begun) return report(begun.error());
  *has_begun = *begun;
  return kOk;
}

IsosplatStatus isosplat_renderer_fade(float progress) {
  Renderer* renderer = current();
  return renderer ? status_of(renderer->fade(progress)) : no_renderer();
}

IsosplatStatus isosplat_renderer_begin_occlusion_query(const uint32_t* handles, uint32_t count,
                                                       int32_t min_px) {
  Renderer* renderer = current();
  if (!renderer) return no_renderer();
  return status_of(renderer->begin_occlusion_query(std::span(handles, count), min_px));
}

IsosplatStatus isosplat_renderer_take_occlusion_query(IsosplatOcclusionAnswer* answer) {
  Renderer* renderer = current();
  if (!renderer) return no_renderer();
  *answer = {};
  const auto taken = renderer->take_occlusion_query();
  if (!taken) return kOk;
  auto& records = state().occlusion_answer;
  records.clear();
  for (const ChunkVisibility& chunk : *taken) {
    IsosplatVisibility& record = records.emplace_back();
    record.handle = chunk.handle;
    const RegionMask::Words tested = chunk.tested.words(), visible = chunk.visible.words();
    std::copy(tested.begin(), tested.end(), record.tested);
    std::copy(visible.begin(), visible.end(), record.visible);
  }
  *answer = {1, static_cast<uint32_t>(records.size())};
  return kOk;
}

const IsosplatVisibility* isosplat_renderer_occlusion_answer() {
  return state().occlusion_answer.data();
}

const char* isosplat_renderer_name() {
  return state().renderer ? state().renderer->limits().renderer.c_str() : "";
}

void isosplat_renderer_context_lost() {
  if (state().renderer) state().renderer->context_lost();
}

IsosplatStatus isosplat_renderer_context_restored() {
  Renderer* renderer = current();
  if (!renderer) return no_renderer();
  enable_extensions();
  return status_of(renderer->context_restored());
}
