#include <cstddef>
#include <span>

#include "shared/bindings/wasm/renderer_api.h"
#include "shared/bindings/wasm/renderer_state.h"

// The functions of renderer_api.h that draw pictures.
using namespace isosplat;
using namespace isosplat::render;
using namespace isosplat::render::wasm;

namespace {

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

}  // namespace

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
                                           int32_t pictures, uint8_t* rgba) {
  Renderer* renderer = current();
  if (!renderer) return no_renderer();
  const size_t bytes = 4 * static_cast<size_t>(width) * static_cast<size_t>(height);
  return report_drawn(renderer->draw_tile(x, y, width, height, pictures, std::span(rgba, bytes)),
                      nullptr);
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
