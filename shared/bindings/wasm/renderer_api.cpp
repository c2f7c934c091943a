#include "shared/bindings/wasm/renderer_api.h"

#include <emscripten/html5.h>

#include <algorithm>
#include <iterator>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "shared/bindings/wasm/renderer_state.h"

using namespace isosplat;
using namespace isosplat::render;
using namespace isosplat::render::wasm;

namespace {

/// A context, new or restored, offers only the extensions that are enabled on it.
void enable_extensions() {
  for (const char* extension : {"EXT_color_buffer_float", "EXT_float_blend",
                                "KHR_parallel_shader_compile", "WEBGL_multi_draw"}) {
    emscripten_webgl_enable_extension(state().context, extension);
  }
}

/// Errors: invalid_argument.
Result<VolumeGrid> grid_of(const IsosplatVolume& record) {
  for (int i = 0; i < 3; ++i) {
    const double voxels = record.voxels[i];
    if (!(voxels >= 2 && voxels <= kMaxVoxelsPerAxis) || !(record.spacing[i] > 0)) {
      return fail(Status::invalid_argument,
                  "a volume needs 2 to 1048576 voxels along each axis, and spacings above 0");
    }
  }
  VolumeGrid grid;
  std::copy(std::begin(record.direction), std::end(record.direction), grid.direction.begin());
  if (!is_basis(grid.direction)) {
    return fail(Status::invalid_argument,
                "a volume's direction needs columns of length 1 that do not lie in a plane");
  }
  grid.voxels = {static_cast<int32_t>(record.voxels[0]), static_cast<int32_t>(record.voxels[1]),
                 static_cast<int32_t>(record.voxels[2])};
  grid.spacing = as_vector(record.spacing);
  grid.origin = as_vector(record.origin);
  return grid;
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

IsosplatStatus isosplat_renderer_set_volume(uint32_t volume, const IsosplatVolume* record) {
  Renderer* renderer = current();
  if (!renderer) return no_renderer();
  const auto grid = grid_of(*record);
  if (!grid) return report(grid.error());
  ValueMapping values;
  values.offset = record->value_offset;
  values.scale = record->value_scale;
  renderer->set_volume(*grid, values, volume);
  return kOk;
}

IsosplatStatus isosplat_renderer_move_volume(uint32_t volume, const IsosplatVolume* record) {
  Renderer* renderer = current();
  if (!renderer) return no_renderer();
  const auto grid = grid_of(*record);
  return grid ? status_of(renderer->move_volume(*grid, volume)) : report(grid.error());
}

void isosplat_renderer_remove_volume(uint32_t volume) {
  isosplat_renderer_set_isosurfaces(volume, nullptr, 0);
  if (Renderer* renderer = current()) renderer->remove_volume(volume);
}

IsosplatStatus isosplat_renderer_reserve_chunk(uint32_t volume, uint32_t handle,
                                               const IsosplatBlock* block, const void* clusters,
                                               uint32_t cluster_bytes, double* offset) {
  Renderer* renderer = current();
  if (!renderer) return no_renderer();
  const Index3 index{static_cast<int32_t>(block->block[0]), static_cast<int32_t>(block->block[1]),
                     static_cast<int32_t>(block->block[2])};
  const auto* first = static_cast<const SampleCluster*>(clusters);
  const auto reserved =
      renderer->reserve_chunk(handle, {block->level, index},
                              {first, first + cluster_bytes / sizeof(SampleCluster)}, volume);
  if (!reserved) return report(reserved.error());
  *offset = static_cast<double>(*reserved);
  return kOk;
}

IsosplatStatus isosplat_renderer_bind_samples(uint32_t volume, uint32_t handle,
                                              IsosplatSampleRange* range) {
  Renderer* renderer = current();
  if (!renderer) return no_renderer();
  const auto bound = renderer->bind_samples(handle, volume);
  if (!bound) return report(bound.error());
  *range = {static_cast<double>(bound->offset_bytes()), static_cast<double>(bound->count)};
  return kOk;
}

IsosplatStatus isosplat_renderer_set_field(uint32_t volume, const IsosplatFieldMapping* record) {
  Renderer* renderer = current();
  if (!renderer) return no_renderer();
  std::optional<ValueMapping> field;
  if (record) {
    field.emplace();
    field->offset = record->value_offset;
    field->scale = record->value_scale;
    field->has_missing = record->has_missing != 0;
  }
  return status_of(renderer->set_field(field, volume));
}

IsosplatStatus isosplat_renderer_reserve_chunk_field(uint32_t volume, uint32_t handle,
                                                     uint32_t samples, double* offset) {
  Renderer* renderer = current();
  if (!renderer) return no_renderer();
  const auto reserved = renderer->reserve_chunk_field(handle, samples, volume);
  if (!reserved) return report(reserved.error());
  *offset = static_cast<double>(*reserved);
  return kOk;
}

IsosplatStatus isosplat_renderer_check_gpu() {
  Renderer* renderer = current();
  return renderer ? status_of(renderer->check_gpu()) : no_renderer();
}

void isosplat_renderer_remove_chunk(uint32_t volume, uint32_t handle) {
  if (Renderer* renderer = current()) renderer->remove_chunk(handle, volume);
}

void isosplat_renderer_set_visible(uint32_t volume, const IsosplatDrawnChunk* chunks,
                                   uint32_t count) {
  if (!state().renderer) return;
  std::vector<DrawnChunk> visible;
  visible.reserve(count);
  for (const IsosplatDrawnChunk& chunk : std::span(chunks, count)) {
    visible.push_back({chunk.handle, RegionMask::from_words(chunk.regions)});
  }
  state().renderer->set_visible(std::span<const DrawnChunk>(visible), volume);
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
