#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "shared/select/chunk_table.h"
#include "shared/select/selection_view.h"
#include "shared/select/visibility.h"
#include "shared/store/store_reader.h"

namespace isosplat {

/// A block with a cell that is active for one of the isovalues, in the frustum.
struct BlockNode {
  BlockKey key;
  int32_t parent = -1;
  double cell_px = 0;
  double centre_distance = 0;
  uint32_t first_handle = 0, handle_count = 0;  ///< of its chunks: BlockTree::handles
  uint64_t cells = 0;
  Visibility visibility = Visibility::visible;
  bool resident = false;          ///< every chunk that it needs is
  bool wanted_finer = false;      ///< refined by this view, not just explored
  bool expanded = false;          ///< its children are known
  bool unknown_children = false;  ///< … but for those whose page is missing
  int32_t first_child = 0, child_count = 0;
  uint8_t empty_octants = 0;      ///< bit x + 2y + 4z: known to have no active cell in the frustum
  bool full_by_children = false;  ///< resident blocks below cover all of it

  bool full() const { return full_by_children || resident; }
};

struct WantedPage {
  uint32_t page;
  double cell_px;
};

/// The blocks that a view comes down to, and all above them: refined best first from the coarsest
/// level, until cells are small enough on the screen, hidden, or the budget is used up. The order
/// does not depend on the budget, which only says where to stop: a larger one refines more.
class BlockTree {
 public:
  /// All must outlive the tree.
  BlockTree(const StoreReader& store, ChunkTable& table, const SelectionView& view,
            const VisibilityMap& visibility);

  /// Call it once. Errors: those of the store's directory.
  Result<void> grow();

  /// Parents before their children, siblings together.
  const std::vector<BlockNode>& nodes() const { return nodes_; }
  std::span<const ChunkHandle> handles(const BlockNode& node) const {
    return std::span(handles_).subspan(node.first_handle, node.handle_count);
  }
  /// Directory pages that are missing.
  const std::vector<WantedPage>& pages() const { return pages_; }
  uint64_t target_cells() const { return target_cells_; }
  bool limited_by_budget() const { return limited_by_budget_; }

  /// Whether the block is one that the view comes down to: neither refined, nor explored below
  /// those.
  bool is_target(const BlockNode& node) const {
    return !node.wanted_finer && (node.parent < 0 || nodes_[node.parent].wanted_finer);
  }

  /// Whether a block above it is resident.
  bool resident_above(const BlockNode& node) const;

 private:
  bool may_be_active(CellInterval interval) const;
  Result<void> add_block(BlockKey key, int32_t parent, bool& page_missing);
  Result<void> expand(int32_t node);
  Result<void> refine();
  Result<void> explore_resident();
  void find_full();

  const StoreReader& store_;
  ChunkTable& table_;
  const SelectionView& view_;
  const VisibilityMap& visibility_;
  ScreenProjection projection_;
  std::vector<LevelGrid> levels_;
  std::vector<BlockNode> nodes_;
  std::vector<ChunkHandle> handles_;
  std::vector<WantedPage> pages_;
  uint64_t target_cells_ = 0;
  bool limited_by_budget_ = false;
};

}  // namespace isosplat
