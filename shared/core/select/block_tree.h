#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "shared/core/select/chunk_table.h"
#include "shared/core/select/selection_view.h"
#include "shared/core/select/visibility.h"
#include "shared/core/store/store_reader.h"

namespace isosplat {

/// A block with a cell that is active for one of the isovalues, in the frustum.
struct BlockNode {
  BlockKey key;
  int32_t parent = -1;
  double cell_px = 0;
  double centre_distance = 0;
  uint32_t first_handle = 0, handle_count = 0;  ///< its chunks: see BlockTree::handles
  uint64_t cells = 0;
  Visibility visibility = Visibility::visible;
  bool resident = false;              ///< all its chunks for these isovalues are resident
  bool is_refined = false;            ///< the view needs its children; explored blocks do not count
  bool expanded = false;              ///< its children are in the tree
  bool has_unknown_children = false;  ///< except those whose directory page is missing
  int32_t first_child = 0, child_count = 0;
  uint8_t empty_octants = 0;  ///< bit x + 2y + 4z: known to have no active cell in the frustum
  bool is_covered_by_children = false;  ///< resident descendants cover all of it

  bool is_covered() const { return is_covered_by_children || resident; }
};

struct WantedPage {
  uint32_t page;
  double cell_px;
};

/// The blocks that a camera view needs, and all their ancestors. The refinement starts at the
/// coarsest level and always refines the block whose cells are largest on the screen. It does not
/// refine hidden blocks or blocks whose cells are small enough, and it stops when the budget is
/// used up. The order does not depend on the budget, so a larger budget refines a superset.
class BlockTree {
 public:
  /// All arguments must outlive the tree.
  BlockTree(const StoreReader& store, ChunkTable& table, const SelectionView& view,
            const VisibilityMap& visibility);

  /// Call this once. Errors: those of StoreReader::chunk_for.
  Result<void> build();

  /// In an order with parents before their children, and siblings contiguous.
  const std::vector<BlockNode>& nodes() const { return nodes_; }
  std::span<const ChunkHandle> handles(const BlockNode& node) const {
    return std::span(handles_).subspan(node.first_handle, node.handle_count);
  }
  /// The directory pages that are needed and not resident.
  const std::vector<WantedPage>& pages() const { return pages_; }
  uint64_t target_cells() const { return target_cells_; }
  bool limited_by_budget() const { return limited_by_budget_; }

  /// Whether the block is at the level that the view needs: neither refined, nor a descendant of
  /// such a block.
  bool is_target(const BlockNode& node) const {
    return !node.is_refined && (node.parent < 0 || nodes_[node.parent].is_refined);
  }

  /// Whether an ancestor of the block is resident.
  bool has_resident_ancestor(const BlockNode& node) const;

 private:
  bool may_be_active(CellInterval interval) const;
  Result<void> add_block(BlockKey key, int32_t parent, bool& page_missing);
  Result<void> expand(int32_t node);
  Result<void> add_coarsest_level();
  Result<void> refine();
  void collapse(int32_t node, size_t handle_count, size_t page_count);
  Result<void> explore_resident_descendants();
  void find_covered_blocks();

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
