#include <algorithm>
#include <iterator>
#include <span>
#include <vector>

#include "shared/bindings/wasm/core_api.h"
#include "shared/bindings/wasm/core_state.h"

// The functions of core_api.h that select the chunks and pages that a camera view needs.
using namespace isosplat;
using namespace isosplat::wasm;

extern "C" {

IsosplatStatus isosplat_core_select(IsosplatCore* core, const IsosplatSelectionView* view,
                                    const float* quantized_isovalues, uint32_t isovalue_count) {
  if (!core->store) return no_store(core);
  SelectionView requested;
  std::copy(std::begin(view->view_projection), std::end(view->view_projection),
            requested.view_projection.begin());
  requested.width_px = view->width_px;
  requested.height_px = view->height_px;
  requested.load_cell_px = view->load_cell_px;
  requested.draw_cell_px = view->draw_cell_px;
  requested.cell_budget = static_cast<uint64_t>(std::clamp(view->cell_budget, 0.0, 9e15));
  requested.occlusion = view->occlusion != 0;
  requested.quantized_isovalues.assign(quantized_isovalues, quantized_isovalues + isovalue_count);
  const auto selection =
      view->ahead ? core->selector->select_ahead(requested) : core->selector->select(requested);
  if (!selection) return report(core, selection.error());

  put_record(core, ISOSPLAT_SELECTION_HEADER,
             IsosplatSelectionHeader{selection->finest_drawn_level, selection->coarsest_drawn_level,
                                     selection->limited_by_budget, selection->undecided});
  std::vector<IsosplatChunk> load;
  for (const ChunkHandle handle : selection->load) {
    load.push_back(chunk_record(core, *core->selector->chunk(handle)));
  }
  put(core, ISOSPLAT_SELECTION_LOAD, load);
  put(core, ISOSPLAT_SELECTION_PAGES, selection->pages);
  std::vector<IsosplatDrawnChunk> draw;
  for (const DrawnChunk& drawn : selection->draw) {
    IsosplatDrawnChunk& record = draw.emplace_back();
    record.handle = drawn.handle;
    const RegionMask::Words regions = drawn.regions.words();
    std::copy(regions.begin(), regions.end(), record.regions);
  }
  put(core, ISOSPLAT_SELECTION_DRAW, draw);
  put(core, ISOSPLAT_SELECTION_TEST, selection->test);
  put(core, ISOSPLAT_SELECTION_KEEP, selection->keep);
  return kOk;
}

IsosplatStatus isosplat_core_set_visibility(IsosplatCore* core, const IsosplatVisibility* answer,
                                            uint32_t count) {
  if (!core->store) return no_store(core);
  std::vector<ChunkVisibility> drawn;
  for (const IsosplatVisibility& chunk : std::span(answer, count)) {
    drawn.push_back({chunk.handle, RegionMask::from_words(chunk.tested),
                     RegionMask::from_words(chunk.visible)});
  }
  const auto set = core->selector->set_visibility(drawn);
  return set ? kOk : report(core, set.error());
}

IsosplatStatus isosplat_core_set_resident(IsosplatCore* core, uint32_t handle, uint32_t resident) {
  if (!core->store) return no_store(core);
  const auto set = core->selector->set_resident(handle, resident != 0);
  return set ? kOk : report(core, set.error());
}

}  // extern "C"
