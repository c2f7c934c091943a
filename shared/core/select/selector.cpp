#include "shared/core/select/selector.h"

#include <algorithm>
#include <cmath>

#include "shared/core/select/block_id.h"
#include "shared/core/select/block_tree.h"
#include "shared/core/select/chunk_table.h"
#include "shared/core/select/visibility.h"

namespace isosplat {
namespace {

constexpr size_t kMaxIsovalues = 64;

/// A chunk to fetch.
struct ChunkToLoad {
  double priority;
  ChunkHandle handle;
  bool operator<(const ChunkToLoad& other) const {
    return priority != other.priority ? priority > other.priority : handle < other.handle;
  }
};

/// Decides which blocks of a BlockTree to fetch, and which to draw until they are resident.
class SelectionBuilder {
 public:
  SelectionBuilder(const ChunkTable& table, const SelectionView& view, const BlockTree& tree)
      : table_(table), view_(view), tree_(tree), ancestor_to_load_(tree.nodes().size()) {}

  Selection build();

 private:
  const BlockNode& node(int32_t index) const { return tree_.nodes()[index]; }
  bool is_wanted(int32_t index) const;
  void mark_ancestors_to_load(const BlockNode& leaf);
  void select_chunks();
  void select_pages();
  void subtract_finer_blocks(int32_t index, const BlockNode& drawn, RegionMask& regions);
  void draw_block(int32_t index);

  const ChunkTable& table_;
  const SelectionView& view_;
  const BlockTree& tree_;
  /// For each node: whether to load it so that its descendants can replace it one by one.
  std::vector<bool> ancestor_to_load_;
  Selection result_;
};

/// Whether the view needs the chunks of this block itself, if it is visible.
bool SelectionBuilder::is_wanted(int32_t index) const {
  const BlockNode& block = node(index);
  if (!tree_.is_target(block)) return ancestor_to_load_[index];
  if (block.visibility == Visibility::hidden && tree_.has_resident_ancestor(block)) return false;
  // Resident finer blocks that cover it replace it, unless they are finer than the screen resolves.
  return !(block.is_covered_by_children && block.cell_px > view_.draw_cell_px);
}

/// A chunk can leave regions to blocks at most kRegionLevels finer. Marks the ancestors of the leaf
/// that must be loaded so that no gap between resident ancestors is larger.
void SelectionBuilder::mark_ancestors_to_load(const BlockNode& leaf) {
  uint32_t level = leaf.key.level + kRegionLevels;
  for (int32_t i = leaf.parent; i >= 0; i = node(i).parent) {
    if (node(i).resident) {
      level = node(i).key.level + kRegionLevels;
    } else if (node(i).key.level == level || node(i).parent < 0) {
      ancestor_to_load_[i] = true;
      level += kRegionLevels;
    }
  }
}

void SelectionBuilder::select_chunks() {
  const auto count = static_cast<int32_t>(tree_.nodes().size());
  for (int32_t i = 0; i < count; ++i) {
    if (tree_.is_target(node(i)) && !node(i).resident && is_wanted(i))
      mark_ancestors_to_load(node(i));
  }
  std::vector<ChunkToLoad> to_load;
  for (int32_t i = 0; i < count; ++i) {
    const BlockNode& block = node(i);
    const bool is_target = tree_.is_target(block);
    if (!block.is_refined && !is_target) continue;  // an explored block
    const bool wanted = is_wanted(i);
    // An occlusion query of the ancestor that is drawn instead decides whether it is needed.
    const bool is_untested = block.visibility == Visibility::untested ||
                             (block.visibility == Visibility::ancestor_visible && is_target);
    const bool is_pending = is_untested && !block.resident && tree_.has_resident_ancestor(block);
    for (const ChunkHandle handle : tree_.handles(block)) {
      if (table_.is_resident(handle)) {
        if (wanted || !block.is_covered_by_children) result_.keep.push_back(handle);
      } else if (wanted && is_pending) {
        ++result_.undecided;
      } else if (wanted) {
        to_load.push_back({block.cell_px / (1 + 0.5 * block.centre_distance), handle});
      }
    }
  }
  std::sort(to_load.begin(), to_load.end());
  for (const ChunkToLoad& chunk : to_load) result_.load.push_back(chunk.handle);
}

void SelectionBuilder::select_pages() {
  std::vector<WantedPage> pages = tree_.pages();
  std::sort(pages.begin(), pages.end(),
            [](WantedPage a, WantedPage b) { return a.cell_px > b.cell_px; });
  std::vector<uint32_t>& listed = result_.pages;
  for (const WantedPage& page : pages) {
    if (std::find(listed.begin(), listed.end(), page.page) == listed.end()) {
      listed.push_back(page.page);
    }
  }
}

/// The regions of the block `drawn` that its descendant `child` covers, at most kRegionLevels
/// finer.
RegionMask regions_of(BlockKey child, BlockKey drawn) {
  const uint32_t levels = drawn.level - child.level;
  const Index3 origin = drawn.index;
  return RegionMask::of_block_below(
      {child.index.x - (origin.x << levels), child.index.y - (origin.y << levels),
       child.index.z - (origin.z << levels)},
      levels);
}

/// Draws the covered descendants of the node, and subtracts their regions from those of the chunk
/// that is drawn for `drawn`. Also subtracts blocks without an active cell, because a coarse cell
/// may be active where no finer cell is.
void SelectionBuilder::subtract_finer_blocks(int32_t index, const BlockNode& drawn,
                                             RegionMask& regions) {
  const BlockNode& block = node(index);
  for (int32_t octant = 0; octant < 8; ++octant) {
    if ((block.empty_octants >> octant & 1) == 0) continue;
    const Index3 corner{2 * block.key.index.x, 2 * block.key.index.y, 2 * block.key.index.z};
    const Index3 child{corner.x + (octant & 1), corner.y + (octant >> 1 & 1),
                       corner.z + (octant >> 2)};
    regions -= regions_of({block.key.level - 1, child}, drawn.key);
  }
  for (int32_t c = block.first_child; c < block.first_child + block.child_count; ++c) {
    const BlockKey child = node(c).key;
    const uint32_t levels = drawn.key.level - child.level;
    if (node(c).is_covered()) {
      regions -= regions_of(child, drawn.key);
      draw_block(c);
    } else if (levels < kRegionLevels) {
      subtract_finer_blocks(c, drawn, regions);
    }
  }
}

void SelectionBuilder::draw_block(int32_t index) {
  const BlockNode& block = node(index);
  if (!block.resident || block.is_covered_by_children) {
    // If it is neither resident nor covered, no ancestor is resident: draws the resident
    // descendants.
    for (int32_t c = 0; c < block.child_count; ++c) draw_block(block.first_child + c);
    return;
  }
  RegionMask regions = RegionMask::all();
  subtract_finer_blocks(index, block, regions);
  if (!regions.any()) return;
  const bool replaces_finer_blocks =
      block.key.level > 0 && (block.is_refined || block.cell_px > view_.load_cell_px);
  for (const ChunkHandle handle : tree_.handles(block)) {
    result_.draw.push_back({handle, regions});
    if (replaces_finer_blocks) result_.test.push_back(handle);
  }
  const auto level = static_cast<int32_t>(block.key.level);
  auto& finest = result_.finest_drawn_level;
  finest = finest < 0 ? level : std::min(finest, level);
  if (replaces_finer_blocks && block.visibility == Visibility::hidden) return;
  result_.coarsest_drawn_level = std::max(result_.coarsest_drawn_level, level);
}

Selection SelectionBuilder::build() {
  select_chunks();
  select_pages();
  const std::vector<BlockNode>& nodes = tree_.nodes();
  for (size_t i = 0; i < nodes.size() && nodes[i].parent < 0; ++i)
    draw_block(static_cast<int32_t>(i));
  result_.coarsest_drawn_level = std::max(result_.coarsest_drawn_level, result_.finest_drawn_level);
  result_.target_cells = tree_.target_cells();
  result_.limited_by_budget = tree_.limited_by_budget();
  return std::move(result_);
}

bool is_usable(const SelectionView& view) {
  const auto finite = [](double value) { return std::isfinite(value); };
  return std::all_of(view.view_projection.begin(), view.view_projection.end(), finite) &&
         view.width_px > 0 && view.height_px > 0 && finite(view.width_px) &&
         finite(view.height_px) && view.load_cell_px > 0 && view.draw_cell_px > 0 &&
         view.quantized_isovalues.size() <= kMaxIsovalues;
}

/// Whether an occlusion query in one view is valid in the other.
bool same_visibility(const SelectionView& a, const SelectionView& b) {
  return a.view_projection == b.view_projection && a.width_px == b.width_px &&
         a.height_px == b.height_px && a.quantized_isovalues == b.quantized_isovalues;
}

}  // namespace

struct Selector::State {
  const StoreReader* store;
  ChunkTable table;
  SelectionView visibility_view;  ///< the view of the queries in `visibility`
  VisibilityMap visibility;

  Result<Selection> select(const SelectionView& view) {
    if (!is_usable(view)) {
      return fail(Status::invalid_argument,
                  "view: expected a finite matrix and size, cell sizes above 0, and at most "
                  "64 isovalues");
    }
    BlockTree tree(*store, table, view, visibility);
    if (auto built = tree.build(); !built) return tl::unexpected(built.error());
    return SelectionBuilder(table, view, tree).build();
  }
};

Selector::Selector(const StoreReader& store) : state_(new State{&store, {}, {}, {}}) {}
Selector::Selector(Selector&&) noexcept = default;
Selector& Selector::operator=(Selector&&) noexcept = default;
Selector::~Selector() = default;

ChunkHandle Selector::handle_of(const ChunkRef& chunk) {
  return state_->table.handle_of(chunk);
}

Result<ChunkRef> Selector::chunk(ChunkHandle handle) const {
  if (!state_->table.contains(handle)) {
    return fail(Status::not_found, "chunk handle " + std::to_string(handle) + " is unknown");
  }
  return state_->table.chunk(handle);
}

Result<void> Selector::set_resident(ChunkHandle handle, bool resident) {
  if (auto known = chunk(handle); !known) return tl::unexpected(known.error());
  state_->table.set_resident(handle, resident);
  return {};
}

Result<Selection> Selector::select(const SelectionView& view) {
  if (!same_visibility(view, state_->visibility_view)) {
    state_->visibility_view = view;
    state_->visibility.clear();
  }
  return state_->select(view);
}

Result<Selection> Selector::select_ahead(const SelectionView& view) {
  SelectionView expected = view;
  expected.occlusion = false;
  return state_->select(expected);
}

Result<void> Selector::set_visibility(std::span<const ChunkVisibility> result) {
  state_->visibility.clear();
  for (const ChunkVisibility& drawn : result) {
    const auto known = chunk(drawn.handle);
    if (!known) return tl::unexpected(known.error());
    state_->visibility.add(known->block, drawn.tested, drawn.visible);
  }
  return {};
}

}  // namespace isosplat
