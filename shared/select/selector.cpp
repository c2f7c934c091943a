#include "shared/select/selector.h"

#include <algorithm>
#include <cmath>

#include "shared/select/block_id.h"
#include "shared/select/block_tree.h"
#include "shared/select/chunk_table.h"
#include "shared/select/visibility.h"

namespace isosplat {
namespace {

constexpr size_t kMaxIsovalues = 64;

/// A chunk to fetch.
struct Need {
  double priority;
  ChunkHandle handle;
  bool operator<(const Need& other) const {
    return priority != other.priority ? priority > other.priority : handle < other.handle;
  }
};

/// What of a view's blocks is to be fetched, and what is drawn until it is there.
class SelectionMaker {
 public:
  SelectionMaker(const ChunkTable& table, const SelectionView& view, const BlockTree& tree)
      : table_(table), view_(view), tree_(tree), on_the_way_(tree.nodes().size()) {}

  Selection make();

 private:
  const BlockNode& node(int32_t index) const { return tree_.nodes()[index]; }
  bool is_wanted(int32_t index) const;
  void mark_way(const BlockNode& leaf);
  void list_needs();
  void list_pages();
  void carve(int32_t index, const BlockNode& drawn, RegionMask& regions);
  void emit(int32_t index);

  const ChunkTable& table_;
  const SelectionView& view_;
  const BlockTree& tree_;
  std::vector<bool> on_the_way_;  ///< by node: wanted for blocks below it to come in one by one
  Selection result_;
};

/// Whether the view needs the block's own chunks, if it can be seen.
bool SelectionMaker::is_wanted(int32_t index) const {
  const BlockNode& block = node(index);
  if (!tree_.is_target(block)) return on_the_way_[index];
  if (block.visibility == Visibility::hidden && tree_.resident_above(block)) return false;
  // Finer blocks that are all there serve as well, unless they are finer than can be seen.
  return !(block.full_by_children && block.cell_px > view_.draw_cell_px);
}

/// A chunk leaves regions to blocks at most kRegionLevels below it: marks what is missing for that
/// between the leaf and the coarsest level.
void SelectionMaker::mark_way(const BlockNode& leaf) {
  uint32_t level = leaf.key.level + kRegionLevels;
  for (int32_t i = leaf.parent; i >= 0; i = node(i).parent) {
    if (node(i).resident) {
      level = node(i).key.level + kRegionLevels;
    } else if (node(i).key.level == level || node(i).parent < 0) {
      on_the_way_[i] = true;
      level += kRegionLevels;
    }
  }
}

void SelectionMaker::list_needs() {
  const auto count = static_cast<int32_t>(tree_.nodes().size());
  for (int32_t i = 0; i < count; ++i) {
    if (tree_.is_target(node(i)) && !node(i).resident && is_wanted(i)) mark_way(node(i));
  }
  std::vector<Need> needs;
  for (int32_t i = 0; i < count; ++i) {
    const BlockNode& block = node(i);
    const bool is_target = tree_.is_target(block);
    if (!block.wanted_finer && !is_target) continue;  // only explored
    const bool wanted = is_wanted(i);
    // What is drawn in the block's place is about to be tested.
    const bool is_open = block.visibility == Visibility::untested ||
                         (block.visibility == Visibility::ancestor_visible && is_target);
    const bool waits = is_open && !block.resident && tree_.resident_above(block);
    for (const ChunkHandle handle : tree_.handles(block)) {
      if (table_.is_resident(handle)) {
        if (wanted || !block.full_by_children) result_.keep.push_back(handle);
      } else if (wanted && waits) {
        ++result_.undecided;
      } else if (wanted) {
        needs.push_back({block.cell_px / (1 + 0.5 * block.centre_distance), handle});
      }
    }
  }
  std::sort(needs.begin(), needs.end());
  for (const Need& need : needs) result_.load.push_back(need.handle);
}

void SelectionMaker::list_pages() {
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

/// The regions of the block `drawn` that a block at most kRegionLevels below it covers.
RegionMask regions_of(BlockKey child, BlockKey drawn) {
  const uint32_t levels = drawn.level - child.level;
  const Index3 origin = drawn.index;
  return RegionMask::of_block_below(
      {child.index.x - (origin.x << levels), child.index.y - (origin.y << levels),
       child.index.z - (origin.z << levels)},
      levels);
}

/// Emits what is below the node and can be drawn by itself, and takes its regions from the drawn
/// chunk's; also those of blocks without an active cell: a coarse cell may be active where no finer
/// one is.
void SelectionMaker::carve(int32_t index, const BlockNode& drawn, RegionMask& regions) {
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
    if (node(c).full()) {
      regions -= regions_of(child, drawn.key);
      emit(c);
    } else if (levels < kRegionLevels) {
      carve(c, drawn, regions);
    }
  }
}

void SelectionMaker::emit(int32_t index) {
  const BlockNode& block = node(index);
  if (!block.resident || block.full_by_children) {
    // Not resident and not full: nothing above is resident either. What is there is shown.
    for (int32_t c = 0; c < block.child_count; ++c) emit(block.first_child + c);
    return;
  }
  RegionMask regions = RegionMask::all();
  carve(index, block, regions);
  if (!regions.any()) return;
  const bool stands_for_finer =
      block.key.level > 0 && (block.wanted_finer || block.cell_px > view_.load_cell_px);
  for (const ChunkHandle handle : tree_.handles(block)) {
    result_.draw.push_back({handle, regions});
    if (stands_for_finer) result_.test.push_back(handle);
  }
  const auto level = static_cast<int32_t>(block.key.level);
  auto& finest = result_.finest_drawn_level;
  finest = finest < 0 ? level : std::min(finest, level);
  if (stands_for_finer && block.visibility == Visibility::hidden) return;
  result_.coarsest_drawn_level = std::max(result_.coarsest_drawn_level, level);
}

Selection SelectionMaker::make() {
  list_needs();
  list_pages();
  const std::vector<BlockNode>& nodes = tree_.nodes();
  for (size_t i = 0; i < nodes.size() && nodes[i].parent < 0; ++i) emit(static_cast<int32_t>(i));
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
         !view.quantized_isovalues.empty() && view.quantized_isovalues.size() <= kMaxIsovalues;
}

/// Whether what can be seen in one view is the same in the other, but for what hides it.
bool same_visibility(const SelectionView& a, const SelectionView& b) {
  return a.view_projection == b.view_projection && a.width_px == b.width_px &&
         a.height_px == b.height_px && a.quantized_isovalues == b.quantized_isovalues;
}

}  // namespace

struct Selector::State {
  const StoreReader* store;
  ChunkTable table;
  SelectionView seen_from;  ///< the view that `visibility` is of
  VisibilityMap visibility;

  Result<Selection> select(const SelectionView& view) {
    if (!is_usable(view)) {
      return fail(Status::invalid_argument,
                  "view: expected a finite matrix and size, cell sizes above 0, and 1 to 64 "
                  "isovalues");
    }
    BlockTree tree(*store, table, view, visibility);
    if (auto grown = tree.grow(); !grown) return tl::unexpected(grown.error());
    return SelectionMaker(table, view, tree).make();
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
    return fail(Status::not_found, "chunk handle " + std::to_string(handle) + " was never given");
  }
  return state_->table.chunk(handle);
}

Result<void> Selector::set_resident(ChunkHandle handle, bool resident) {
  if (auto known = chunk(handle); !known) return tl::unexpected(known.error());
  state_->table.set_resident(handle, resident);
  return {};
}

Result<Selection> Selector::select(const SelectionView& view) {
  if (!same_visibility(view, state_->seen_from)) {
    state_->seen_from = view;
    state_->visibility.clear();
  }
  return state_->select(view);
}

Result<Selection> Selector::select_ahead(const SelectionView& view) {
  SelectionView expected = view;
  expected.occlusion = false;
  return state_->select(expected);
}

Result<void> Selector::set_visibility(std::span<const ChunkVisibility> answer) {
  state_->visibility.clear();
  for (const ChunkVisibility& drawn : answer) {
    const auto known = chunk(drawn.handle);
    if (!known) return tl::unexpected(known.error());
    state_->visibility.add(known->block, drawn.tested, drawn.visible);
  }
  return {};
}

}  // namespace isosplat
