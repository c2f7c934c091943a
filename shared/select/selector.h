#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "shared/select/view.h"
#include "shared/store/store_reader.h"

namespace isosplat {

/// A small number for a chunk that has come up in a selection; stays the same for the Selector's
/// lifetime.
using ChunkHandle = uint32_t;

/// A chunk to draw. A block's 64³ cells are 4×4×4 regions of 16³: bit (x >> 4) + 4·(y >> 4) +
/// 16·(z >> 4) of `regions` says whether this chunk draws the cells of that region; where it does
/// not, finer chunks do.
struct DrawnChunk {
  ChunkHandle handle = 0;
  uint64_t regions = ~uint64_t{0};

  friend bool operator==(const DrawnChunk&, const DrawnChunk&) = default;
};

/// What a view needs.
struct Selection {
  std::vector<uint32_t> pages;      ///< directory pages to fetch, the most needed first
  std::vector<ChunkHandle> load;    ///< chunks to fetch, the most needed first
  std::vector<DrawnChunk> draw;     ///< resident chunks to draw now
  std::vector<ChunkHandle> keep;    ///< resident chunks that this view needs, drawn yet or not
  int32_t finest_drawn_level = -1;  ///< −1: nothing is drawn
  int32_t coarsest_drawn_level = -1;
  uint64_t target_cells = 0;  ///< of the chunks that this view comes down to when all is loaded
  bool limited_by_budget = false;

  bool complete() const { return pages.empty() && load.empty(); }
};

/// Chooses, for a view, which blocks to show at which level: best first, by the size of their cells
/// on the screen, until that is small enough or the budget is used up. A larger budget always
/// refines a superset, so no view gets worse by it.
///
/// What is drawn never has a hole, and nothing is drawn twice: a region is drawn by a coarser chunk
/// until all finer chunks of the region are resident. A block without a cell that is active counts
/// as there. A coarse chunk can leave regions of blocks up to two levels below it to them. So that
/// finer blocks come in few at a time, a level three above what is wanted is fetched on the way,
/// where nothing as fine is there yet.
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
  Result<Selection> select(const View& view);

  /// As select, for a view that is only expected: leaves no trace in what the next selection holds
  /// on to.
  Result<Selection> select_ahead(const View& view);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace isosplat
