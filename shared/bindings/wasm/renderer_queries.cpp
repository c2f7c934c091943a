#include <algorithm>
#include <span>

#include "shared/bindings/wasm/renderer_api.h"
#include "shared/bindings/wasm/renderer_state.h"

// The functions of renderer_api.h that query a picture: the surface at a position in the image, and
// the visible regions of chunks.
using namespace isosplat;
using namespace isosplat::render;
using namespace isosplat::render::wasm;

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
  const RenderSettings& settings = state().renderer->settings();
  pick->volume = settings.slice_volume;
  if (!p.slice && p.isosurface < settings.isosurfaces.size()) {
    const auto& all = settings.isosurfaces;
    pick->volume = all[p.isosurface].volume;
    pick->isosurface = static_cast<uint32_t>(
        std::count_if(all.begin(), all.begin() + p.isosurface,
                      [&](const Isosurface& each) { return each.volume == pick->volume; }));
  }
  pick->level = p.level;
  pick->value = p.value;
  pick->field = p.field.value_or(0);
  pick->has_field = p.field.has_value();
  pick->found = 1;
  pick->face = p.slice ? 2 : p.cap ? 1 : 0;
  return kOk;
}

IsosplatStatus isosplat_renderer_begin_occlusion_query(uint32_t volume, const uint32_t* handles,
                                                       uint32_t count, int32_t min_px) {
  Renderer* renderer = current();
  if (!renderer) return no_renderer();
  return status_of(renderer->begin_occlusion_query(std::span(handles, count), min_px, volume));
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
