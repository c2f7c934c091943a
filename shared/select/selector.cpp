#include "shared/select/selector.h"

#include <algorithm>
#include <cmath>
#include <queue>
#include <unordered_set>

#include "shared/select/chunk_table.h"
#include "shared/select/sight.h"

namespace isosplat {
namespace {

/// A block that was refined stays so until its cells are smaller than 1/1.25 of what would refine
/// it anew: a view that trembles changes nothing.
constexpr double kHysteresis = 1.25;

constexpr size_t kMaxIsocodes = 64;

/// A block with a cell that is active for one of the isovalues, in the frustum.
struct Node {
  BlockKey key;
  unsigned octant = 0;  ///< in its parent
  int32_t parent = -1;
  double cell_px = 0;
  double centre_distance = 0;
  uint32_t first_handle = 0, handle_count = 0;  ///< in Traversal::handles
  uint64_t cells = 0;
  Sight sight = Sight::seen;
  bool resident = false;          ///< every chunk that it needs is
  bool wanted_finer = false;      ///< refined by this view, not just explored
  bool expanded = false;          ///< its children are known
  bool unknown_children = false;  ///< … but for those whose page is missing
  int32_t first_child = 0, child_count = 0;
  bool full_by_children = false;  ///< resident blocks below cover all of it
  bool on_the_way = false;        ///< wanted for blocks below it to come in one by one

  bool full() const { return full_by_children || resident; }
};

/// A chunk to fetch.
struct Need {
  double priority;
  ChunkHandle handle;
  bool operator<(const Need& other) const {
    return priority != other.priority ? priority > other.priority : handle < other.handle;
  }
};

struct WantedPage {
  uint32_t page;
  double cell_px;
};

class Traversal {
 public:
  Traversal(const StoreReader& store, ChunkTable& table, const View& view, const SightMap& sight,
            const std::unordered_set<uint64_t>& refined_before)
      : store_(store),
        table_(table),
        view_(view),
        sight_(sight),
        refined_before_(refined_before),
        projection_(store.info().grid, view) {
    for (uint32_t l = 0; l < store.info().levels; ++l) {
      levels_.push_back(level_grid(store.info().grid.voxels, l));
    }
  }

  Result<Selection> run(std::unordered_set<uint64_t>& refined_now);

 private:
  bool may_be_active(CellInterval interval) const {
    return std::any_of(view_.isocodes.begin(), view_.isocodes.end(),
                       [&](float isocode) { return is_active(interval, isocode); });
  }

  /// Adds the block as a node, if it has an active cell and is in sight. Names its page, if that is
  /// missing.
  Result<void> add_block(BlockKey key, int32_t parent, unsigned octant, bool& page_missing);
  Result<void> expand(int32_t node);
  Result<void> refine();
  Result<void> explore_resident();
  void find_full();
  bool is_target(const Node& node) const;
  bool resident_above(const Node& node) const;
  bool is_wanted(const Node& node) const;
  void mark_way(const Node& leaf);
  void list_needs();
  void carve(int32_t node, const Node& drawn, RegionMask& regions);
  void emit(int32_t node);

  const StoreReader& store_;
  ChunkTable& table_;
  const View& view_;
  const SightMap& sight_;
  const std::unordered_set<uint64_t>& refined_before_;
  ScreenProjection projection_;
  std::vector<LevelGrid> levels_;
  std::vector<Node> nodes_;  ///< parents before their children, siblings together
  std::vector<ChunkHandle> handles_;
  std::vector<WantedPage> pages_;
  Selection result_;
};

Result<void> Traversal::add_block(BlockKey key, int32_t parent, unsigned octant,
                                  bool& page_missing) {
  const auto page = store_.page_of(key);
  if (!page) return tl::unexpected(page.error());
  if (!may_be_active(store_.pages()[*page].interval)) return {};
  const auto footprint = projection_.footprint(levels_[key.level], key.index);
  if (footprint.outside) return {};
  if (!store_.is_resident(*page)) {
    pages_.push_back({*page, footprint.cell_px});
    page_missing = true;
    return {};
  }
  Node node;
  node.key = key;
  node.octant = octant;
  node.parent = parent;
  node.cell_px = footprint.cell_px;
  node.centre_distance = footprint.centre_distance;
  if (view_.occlusion) node.sight = sight_.of(key);
  node.first_handle = static_cast<uint32_t>(handles_.size());
  node.resident = true;
  for (const float isocode : view_.isocodes) {
    const auto chunk = store_.chunk_for(key, isocode);
    if (!chunk) return tl::unexpected(chunk.error());
    if (!*chunk) continue;
    const ChunkHandle handle = table_.handle_of(**chunk);
    if (std::find(handles_.begin() + node.first_handle, handles_.end(), handle) != handles_.end()) {
      continue;
    }
    handles_.push_back(handle);
    node.cells += (*chunk)->cells;
    node.resident = node.resident && table_.is_resident(handle);
  }
  node.handle_count = static_cast<uint32_t>(handles_.size()) - node.first_handle;
  if (node.handle_count != 0) nodes_.push_back(node);
  return {};
}

Result<void> Traversal::expand(int32_t index) {
  const BlockKey parent = nodes_[index].key;
  const LevelGrid& level = levels_[parent.level - 1];
  const auto first = static_cast<int32_t>(nodes_.size());
  bool page_missing = false;
  for (unsigned octant = 0; octant < 8; ++octant) {
    const Index3 child{parent.index.x * 2 + static_cast<int32_t>(octant & 1),
                       parent.index.y * 2 + static_cast<int32_t>(octant >> 1 & 1),
                       parent.index.z * 2 + static_cast<int32_t>(octant >> 2)};
    if (child.x >= level.blocks.x || child.y >= level.blocks.y || child.z >= level.blocks.z) {
      continue;
    }
    if (auto added = add_block({level.level, child}, index, octant, page_missing); !added) {
      return added;
    }
  }
  nodes_[index].expanded = true;
  nodes_[index].unknown_children = page_missing;
  nodes_[index].first_child = first;
  nodes_[index].child_count = static_cast<int32_t>(nodes_.size()) - first;
  return {};
}

/// Best first from the coarsest level, until cells are small enough or the budget is used up. The
/// order does not depend on the budget, which only says where to stop: a larger one refines more.
Result<void> Traversal::refine() {
  const LevelGrid& coarsest = levels_.back();
  bool page_missing = false;
  for (int32_t z = 0; z < coarsest.blocks.z; ++z) {
    for (int32_t y = 0; y < coarsest.blocks.y; ++y) {
      for (int32_t x = 0; x < coarsest.blocks.x; ++x) {
        auto added = add_block({coarsest.level, {x, y, z}}, -1, 0, page_missing);
        if (!added) return added;
      }
    }
  }

  struct Candidate {
    double priority;
    int32_t node;
    bool operator<(const Candidate& other) const {
      return priority != other.priority ? priority < other.priority : node > other.node;
    }
  };
  std::priority_queue<Candidate> queue;
  const auto enqueue = [&](int32_t index) {
    const Node& node = nodes_[index];
    if (node.key.level == 0 || node.sight == Sight::hidden) return;
    const bool held = refined_before_.contains(block_code(node.key));
    const double priority = node.cell_px * (held ? kHysteresis : 1);
    if (priority > view_.load_cell_px) queue.push({priority, index});
  };
  uint64_t total = 0;
  for (size_t i = 0; i < nodes_.size(); ++i) {
    total += nodes_[i].cells;
    enqueue(static_cast<int32_t>(i));
  }
  while (!queue.empty()) {
    const int32_t index = queue.top().node;
    queue.pop();
    const size_t nodes_before = nodes_.size();
    const size_t handles_before = handles_.size();
    const size_t pages_before = pages_.size();
    if (auto expanded = expand(index); !expanded) return expanded;
    uint64_t below = 0;
    for (size_t i = nodes_before; i < nodes_.size(); ++i) below += nodes_[i].cells;
    Node& node = nodes_[index];
    const uint64_t refined = total - (node.unknown_children ? 0 : node.cells) + below;
    if (refined > view_.cell_budget) {
      nodes_.resize(nodes_before);
      handles_.resize(handles_before);
      pages_.resize(pages_before);
      node.expanded = node.unknown_children = false;
      node.child_count = 0;
      result_.limited_by_budget = true;
      break;
    }
    total = refined;
    node.wanted_finer = true;
    for (size_t i = nodes_before; i < nodes_.size(); ++i) enqueue(static_cast<int32_t>(i));
  }
  result_.target_cells = total;
  return {};
}

/// Below what this view wants there may be finer blocks left from another: they are drawn while
/// coarser ones are on their way, and while the camera moves.
Result<void> Traversal::explore_resident() {
  const std::vector<WantedPage> wanted_pages = pages_;
  for (size_t i = 0; i < nodes_.size(); ++i) {
    const Node& node = nodes_[i];
    if (node.expanded || node.key.level == 0) continue;
    if (node.resident && node.cell_px <= view_.draw_cell_px) continue;
    if (!table_.any_resident_below(node.key)) continue;
    if (auto expanded = expand(static_cast<int32_t>(i)); !expanded) return expanded;
  }
  pages_ = wanted_pages;
  return {};
}

void Traversal::find_full() {
  for (size_t i = nodes_.size(); i-- > 0;) {
    Node& node = nodes_[i];
    if (!node.expanded || node.unknown_children) continue;
    const auto first = nodes_.begin() + node.first_child;
    node.full_by_children = std::all_of(first, first + node.child_count,
                                        [](const Node& child) { return child.full(); });
  }
}

/// Whether the block is one that the view comes down to: neither refined, nor explored below those.
bool Traversal::is_target(const Node& node) const {
  return !node.wanted_finer && (node.parent < 0 || nodes_[node.parent].wanted_finer);
}

bool Traversal::resident_above(const Node& node) const {
  for (int32_t i = node.parent; i >= 0; i = nodes_[i].parent) {
    if (nodes_[i].resident) return true;
  }
  return false;
}

/// Whether the view needs the block's own chunks, if it can be seen.
bool Traversal::is_wanted(const Node& node) const {
  if (!is_target(node)) return node.on_the_way;
  if (node.sight == Sight::hidden && resident_above(node)) return false;
  // Finer blocks that are all there serve as well, unless they are finer than can be seen.
  return !(node.full_by_children && node.cell_px > view_.draw_cell_px);
}

/// A chunk leaves regions to blocks at most kRegionLevels below it: marks what is missing for that
/// between the leaf and the coarsest level.
void Traversal::mark_way(const Node& leaf) {
  uint32_t level = leaf.key.level + kRegionLevels;
  for (int32_t i = leaf.parent; i >= 0; i = nodes_[i].parent) {
    Node& node = nodes_[i];
    if (node.resident) {
      level = node.key.level + kRegionLevels;
    } else if (node.key.level == level || node.parent < 0) {
      node.on_the_way = true;
      level += kRegionLevels;
    }
  }
}

void Traversal::list_needs() {
  for (const Node& node : nodes_) {
    if (is_target(node) && !node.resident && is_wanted(node)) mark_way(node);
  }
  std::vector<Need> needs;
  for (const Node& node : nodes_) {
    if (!node.wanted_finer && !is_target(node)) continue;  // only explored
    const bool wanted = is_wanted(node);
    // What is drawn in the block's place is about to be tested.
    const bool is_open =
        node.sight == Sight::unknown || (node.sight == Sight::coarse && is_target(node));
    const bool waits = is_open && !node.resident && resident_above(node);
    for (uint32_t h = 0; h < node.handle_count; ++h) {
      const ChunkHandle handle = handles_[node.first_handle + h];
      if (table_.is_resident(handle)) {
        if (wanted || !node.full_by_children) result_.keep.push_back(handle);
      } else if (wanted && waits) {
        ++result_.undecided;
      } else if (wanted) {
        needs.push_back({node.cell_px / (1 + 0.5 * node.centre_distance), handle});
      }
    }
  }
  std::sort(needs.begin(), needs.end());
  for (const Need& need : needs) result_.load.push_back(need.handle);

  std::sort(pages_.begin(), pages_.end(),
            [](WantedPage a, WantedPage b) { return a.cell_px > b.cell_px; });
  for (const WantedPage& page : pages_) {
    if (std::find(result_.pages.begin(), result_.pages.end(), page.page) == result_.pages.end()) {
      result_.pages.push_back(page.page);
    }
  }
}

/// Emits what is below the node and can be drawn by itself, and takes its regions from the drawn
/// chunk's.
void Traversal::carve(int32_t index, const Node& drawn, RegionMask& regions) {
  const Node& node = nodes_[index];
  for (int32_t c = node.first_child; c < node.first_child + node.child_count; ++c) {
    const BlockKey child = nodes_[c].key;
    const uint32_t levels = drawn.key.level - child.level;
    if (nodes_[c].full()) {
      const Index3 origin = drawn.key.index;
      regions -= RegionMask::of_block_below(
          {child.index.x - (origin.x << levels), child.index.y - (origin.y << levels),
           child.index.z - (origin.z << levels)},
          levels);
      emit(c);
    } else if (levels < kRegionLevels) {
      carve(c, drawn, regions);
    }
  }
}

void Traversal::emit(int32_t index) {
  const Node& node = nodes_[index];
  if (!node.resident || node.full_by_children) {
    // Not resident and not full: nothing above is resident either. What is there is shown.
    for (int32_t c = 0; c < node.child_count; ++c) emit(node.first_child + c);
    return;
  }
  RegionMask regions = RegionMask::all();
  carve(index, node, regions);
  if (!regions.any()) return;
  const bool stands_for_finer =
      node.key.level > 0 && (node.wanted_finer || node.cell_px > view_.load_cell_px);
  for (uint32_t h = 0; h < node.handle_count; ++h) {
    const ChunkHandle handle = handles_[node.first_handle + h];
    result_.draw.push_back({handle, regions});
    if (stands_for_finer) result_.test.push_back(handle);
  }
  const auto level = static_cast<int32_t>(node.key.level);
  auto& finest = result_.finest_drawn_level;
  finest = finest < 0 ? level : std::min(finest, level);
  result_.coarsest_drawn_level = std::max(result_.coarsest_drawn_level, level);
}

Result<Selection> Traversal::run(std::unordered_set<uint64_t>& refined_now) {
  if (auto done = refine(); !done) return tl::unexpected(done.error());
  if (auto done = explore_resident(); !done) return tl::unexpected(done.error());
  find_full();
  list_needs();
  for (size_t i = 0; i < nodes_.size() && nodes_[i].parent < 0; ++i) emit(static_cast<int32_t>(i));
  for (const Node& node : nodes_) {
    if (node.wanted_finer) refined_now.insert(block_code(node.key));
  }
  return std::move(result_);
}

bool is_usable(const View& view) {
  const auto finite = [](double value) { return std::isfinite(value); };
  return std::all_of(view.view_projection.begin(), view.view_projection.end(), finite) &&
         view.width_px > 0 && view.height_px > 0 && finite(view.width_px) &&
         finite(view.height_px) && view.load_cell_px > 0 && view.draw_cell_px > 0 &&
         !view.isocodes.empty() && view.isocodes.size() <= kMaxIsocodes;
}

/// Whether what can be seen in one view is the same in the other, but for what hides it.
bool same_sight(const View& a, const View& b) {
  return a.view_projection == b.view_projection && a.width_px == b.width_px &&
         a.height_px == b.height_px && a.isocodes == b.isocodes;
}

}  // namespace

struct Selector::State {
  const StoreReader* store;
  ChunkTable table;
  std::unordered_set<uint64_t> refined;  ///< blocks that the last selection refined
  View seen_from;                        ///< the view that `sight` is of
  SightMap sight;

  Result<Selection> select(const View& view, std::unordered_set<uint64_t>& refined_now) {
    if (!is_usable(view)) {
      return fail(Status::invalid_argument,
                  "view: expected a finite matrix and size, cell sizes above 0, and 1 to 64 "
                  "isovalues");
    }
    return Traversal(*store, table, view, sight, refined).run(refined_now);
  }
};

Selector::Selector(const StoreReader& store) : state_(new State{&store, {}, {}, {}, {}}) {}
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

Result<Selection> Selector::select(const View& view) {
  if (!same_sight(view, state_->seen_from)) {
    state_->seen_from = view;
    state_->sight.clear();
  }
  std::unordered_set<uint64_t> refined_now;
  auto selection = state_->select(view, refined_now);
  if (selection) state_->refined = std::move(refined_now);
  return selection;
}

Result<Selection> Selector::select_ahead(const View& view) {
  View expected = view;
  expected.occlusion = false;
  std::unordered_set<uint64_t> refined_now;
  return state_->select(expected, refined_now);
}

Result<void> Selector::set_sight(std::span<const DrawnSight> answer) {
  state_->sight.clear();
  for (const DrawnSight& drawn : answer) {
    const auto known = chunk(drawn.handle);
    if (!known) return tl::unexpected(known.error());
    state_->sight.add(known->block, drawn.tested, drawn.seen);
  }
  return {};
}

}  // namespace isosplat
