#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "shared/grid/drawn_chunk.h"
#include "shared/select/selection_view.h"
#include "shared/store/store_reader.h"

namespace isosplat {

/// What a view needs.
struct Selection {
  std::vector<uint32_t> pages;    ///< directory pages to fetch, the most needed first
  std::vector<ChunkHandle> load;  ///< chunks to fetch, the most needed first
  std::vector<DrawnChunk> draw;   ///< resident chunks to draw now
  std::vector<ChunkHandle> keep;  ///< resident chunks that this view needs, drawn yet or not

  /// Drawn chunks that stand for finer ones. With SelectionView::occlusion: which of their regions
  /// may be seen is to be told by set_visibility, whenever what is drawn has changed.
  std::vector<ChunkHandle> test;
  uint32_t undecided =
      0;  ///< chunks that are wanted if the next set_visibility says they may be seen
  int32_t finest_drawn_level = -1;    ///< −1: nothing is drawn
  int32_t coarsest_drawn_level = -1;  ///< of what is not known to be hidden
  uint64_t target_cells = 0;  ///< of the chunks that this view comes down to when all is loaded
  bool limited_by_budget = false;

  /// Nothing is to be done, unless a test of what is drawn now brings more to light.
  bool complete() const { return pages.empty() && load.empty() && undecided == 0; }
};

/// Chooses, for a view, which blocks to show at which level: best first, by the size of their cells
/// on the screen, until that is small enough or the budget is used up. A larger budget always
/// refines a superset, so no view gets worse by it.
///
/// What is drawn never has a hole, and nothing is drawn twice: a region is drawn by a coarser chunk
/// until the finer chunk is resident, or all that are finer still. A block without a cell that is
/// active counts as there. A coarse chunk can leave regions of blocks up to three levels below it
/// to them, so every third level above what is wanted is fetched on the way, where nothing as fine
/// is there yet.
///
/// Blocks behind what is drawn are left out where SelectionView::occlusion asks for it: their
/// coarser chunks stay, and what is drawn still has no hole. As finer chunks take the place of
/// thick coarse ones, others come to light, or turn out to be hidden; what has been fetched stays.
/// So a view is complete after at most as many tests as it has blocks, and nothing flickers.
///
/// What a complete view draws where it can be seen depends on the view alone: neither on the views
/// before, nor on what else is resident.
class Selector {
 public:
  /// `store` must outlive the selector.
  explicit Selector(const StoreReader& store);
  Selector(Selector&&) noexcept;
  Selector& operator=(Selector&&) noexcept;
  ~Selector();

  /// The handle of a chunk of this store.
  ChunkHandle handle_of(const ChunkRef& chunk);

  /// Requires a handle that a selection or handle_of returned; others are not_found.
  Result<ChunkRef> chunk(ChunkHandle handle) const;

  /// Says that a chunk has been decoded and may be drawn, or no longer may.
  Result<void> set_resident(ChunkHandle handle, bool resident);

  /// Errors: invalid_argument (a matrix or a size that is not finite, no isovalue or more than 64).
  Result<Selection> select(const SelectionView& view);

  /// The answer of a test of what is drawn, in the view selected last: replaces the one before.
  /// Another camera, size or isovalue forgets it. Errors: not_found (a handle).
  Result<void> set_visibility(std::span<const ChunkVisibility> answer);

  /// As select, for a view that is only expected: leaves no trace in what the next selection holds
  /// on to.
  Result<Selection> select_ahead(const SelectionView& view);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace isosplat
