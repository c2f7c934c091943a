#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "shared/core/grid/drawn_chunk.h"
#include "shared/core/select/selection_view.h"
#include "shared/core/store/store_reader.h"

namespace isosplat {

/// The pages and chunks that a camera view needs.
struct Selection {
  std::vector<uint32_t> pages;    ///< directory pages to fetch, most important first
  std::vector<ChunkHandle> load;  ///< chunks to fetch, most important first
  std::vector<DrawnChunk> draw;   ///< resident chunks to draw now
  std::vector<ChunkHandle> keep;  ///< resident chunks that this view needs, drawn or not

  /// Drawn chunks that stand in for finer ones which are not resident, or not needed because they
  /// are occluded. With SelectionView::occlusion, test their regions for visibility whenever `draw`
  /// changes, and pass the result to set_visibility.
  std::vector<ChunkHandle> test;
  /// Chunks that will be needed if the pending occlusion query finds them visible.
  uint32_t undecided = 0;
  int32_t finest_drawn_level = -1;    ///< −1: nothing is drawn
  int32_t coarsest_drawn_level = -1;  ///< of the drawn chunks that may be visible
  /// Cells of all chunks that would be drawn if everything in `load` were resident.
  uint64_t target_cells = 0;
  bool limited_by_budget = false;

  /// Whether nothing is left to fetch, unless an occlusion query of `draw` finds more visible
  /// blocks.
  bool complete() const { return pages.empty() && load.empty() && undecided == 0; }
};

/// Selects the blocks to show and their levels for a camera view. The refinement is best first, by
/// the size of cells on the screen, until cells are small enough or the budget is used up. A larger
/// budget refines the same blocks and more, so it never makes a picture worse.
///
/// The drawn chunks have no holes and no overlaps: a region is drawn by a coarse chunk until finer
/// chunks that cover it are resident. A block without an active cell counts as resident. A coarse
/// chunk can leave regions to blocks at most three levels finer, so the selection also loads every
/// third level between the coarsest level and the needed one, unless such a level is resident.
///
/// With SelectionView::occlusion, occluded blocks are not refined: a coarser chunk is drawn in
/// their place, so there are no holes. Finer chunks cover less of the image than the coarse chunks
/// they replace, so other blocks can become visible. Each query but the last marks at least one
/// more block as needed, and fetched chunks are kept. So a view is complete after at most as
/// many queries as it has blocks, and the picture does not flicker.
///
/// The visible part of a complete picture depends on the view only: not on earlier views, and not
/// on other resident chunks.
class Selector {
 public:
  /// `store` must outlive the selector.
  explicit Selector(const StoreReader& store);
  Selector(Selector&&) noexcept;
  Selector& operator=(Selector&&) noexcept;
  ~Selector();

  /// The handle of a chunk of this store.
  ChunkHandle handle_of(const ChunkRef& chunk);

  /// The chunk of a handle that a selection or handle_of returned. Errors: not_found.
  Result<ChunkRef> chunk(ChunkHandle handle) const;

  /// Marks a chunk as resident or not resident. Errors: not_found.
  Result<void> set_resident(ChunkHandle handle, bool resident);

  /// Errors: invalid_argument (a matrix or a size that is not finite, no isovalue or more than 64).
  Result<Selection> select(const SelectionView& view);

  /// Sets the result of an occlusion query in the view selected last. Replaces the result before. A
  /// view with another camera, size or isovalue discards it. Errors: not_found (a handle).
  Result<void> set_visibility(std::span<const ChunkVisibility> result);

  /// As select, for prefetching in a view that is expected later. Ignores occlusion, and keeps the
  /// result of set_visibility.
  Result<Selection> select_ahead(const SelectionView& view);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace isosplat
