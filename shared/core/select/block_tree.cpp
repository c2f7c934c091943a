#include "shared/core/select/block_tree.h"

#include <algorithm>
#include <queue>

namespace isosplat {

BlockTree::BlockTree(const StoreReader& store, ChunkTable& table, const SelectionView& view,
                     const VisibilityMap& visibility)
    : store_(store),
      table_(table),
      view_(view),
      visibility_(visibility),
      projection_(store.info().grid, view) {
  for (uint32_t l = 0; l < store.info().levels; ++l) {
    levels_.push_back(level_grid(store.info().grid.voxels, l));
  }
}

bool BlockTree::may_be_active(CellInterval interval) const {
  return std::any_of(
      view_.quantized_isovalues.begin(), view_.quantized_isovalues.end(),
      [&](float quantized_isovalue) { return is_active(interval, quantized_isovalue); });
}

/// Adds a node for the block if it has an active cell and is in the frustum. Adds its directory
/// page to pages_ if that is not resident.
Result<void> BlockTree::add_block(BlockKey key, int32_t parent, bool& page_missing) {
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
  BlockNode node;
  node.key = key;
  node.parent = parent;
  node.cell_px = footprint.cell_px;
  node.centre_distance = footprint.centre_distance;
  if (view_.occlusion) node.visibility = visibility_.of(key);
  node.first_handle = static_cast<uint32_t>(handles_.size());
  node.resident = true;
  for (const float quantized_isovalue : view_.quantized_isovalues) {
    const auto chunk = store_.chunk_for(key, quantized_isovalue);
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

Result<void> BlockTree::expand(int32_t index) {
  const BlockKey parent = nodes_[index].key;
  const LevelGrid& level = levels_[parent.level - 1];
  const auto first = static_cast<int32_t>(nodes_.size());
  bool page_missing = false;
  unsigned empty_octants = 0;
  for (unsigned octant = 0; octant < 8; ++octant) {
    const Index3 child{parent.index.x * 2 + static_cast<int32_t>(octant & 1),
                       parent.index.y * 2 + static_cast<int32_t>(octant >> 1 & 1),
                       parent.index.z * 2 + static_cast<int32_t>(octant >> 2)};
    if (child.x >= level.blocks.x || child.y >= level.blocks.y || child.z >= level.blocks.z) {
      continue;
    }
    const size_t nodes_before = nodes_.size();
    bool is_unknown = false;
    if (auto added = add_block({level.level, child}, index, is_unknown); !added) return added;
    page_missing = page_missing || is_unknown;
    if (nodes_.size() == nodes_before && !is_unknown) empty_octants |= 1u << octant;
  }
  nodes_[index].expanded = true;
  nodes_[index].has_unknown_children = page_missing;
  nodes_[index].empty_octants = static_cast<uint8_t>(empty_octants);
  nodes_[index].first_child = first;
  nodes_[index].child_count = static_cast<int32_t>(nodes_.size()) - first;
  return {};
}

/// Undoes expand(). The counts are the numbers of handles and pages before it.
void BlockTree::collapse(int32_t index, size_t handle_count, size_t page_count) {
  BlockNode& node = nodes_[index];
  nodes_.resize(static_cast<size_t>(node.first_child));
  handles_.resize(handle_count);
  pages_.resize(page_count);
  node.expanded = node.has_unknown_children = false;
  node.child_count = 0;
  node.empty_octants = 0;
}

Result<void> BlockTree::add_coarsest_level() {
  const LevelGrid& coarsest = levels_.back();
  bool page_missing = false;
  for (int32_t z = 0; z < coarsest.blocks.z; ++z) {
    for (int32_t y = 0; y < coarsest.blocks.y; ++y) {
      for (int32_t x = 0; x < coarsest.blocks.x; ++x) {
        auto added = add_block({coarsest.level, {x, y, z}}, -1, page_missing);
        if (!added) return added;
      }
    }
  }
  return {};
}

Result<void> BlockTree::refine() {
  if (auto added = add_coarsest_level(); !added) return added;
  struct Candidate {
    double priority;
    int32_t node;
    bool operator<(const Candidate& other) const {
      return priority != other.priority ? priority < other.priority : node > other.node;
    }
  };
  std::priority_queue<Candidate> queue;
  const auto enqueue = [&](int32_t index) {
    const BlockNode& node = nodes_[index];
    if (node.key.level == 0 || node.visibility == Visibility::hidden) return;
    if (node.cell_px > view_.load_cell_px) queue.push({node.cell_px, index});
  };
  uint64_t cells_in_total = 0;
  for (size_t i = 0; i < nodes_.size(); ++i) {
    cells_in_total += nodes_[i].cells;
    enqueue(static_cast<int32_t>(i));
  }
  while (!queue.empty()) {
    const int32_t index = queue.top().node;
    queue.pop();
    const size_t nodes_before = nodes_.size();
    const size_t handles_before = handles_.size();
    const size_t pages_before = pages_.size();
    if (auto expanded = expand(index); !expanded) return expanded;
    uint64_t child_cells = 0;
    for (size_t i = nodes_before; i < nodes_.size(); ++i) child_cells += nodes_[i].cells;
    BlockNode& node = nodes_[index];
    const uint64_t refined =
        cells_in_total - (node.has_unknown_children ? 0 : node.cells) + child_cells;
    if (refined > view_.cell_budget) {
      collapse(index, handles_before, pages_before);
      limited_by_budget_ = true;
      break;
    }
    cells_in_total = refined;
    node.is_refined = true;
    for (size_t i = nodes_before; i < nodes_.size(); ++i) enqueue(static_cast<int32_t>(i));
  }
  target_cells_ = cells_in_total;
  return {};
}

/// Adds resident blocks that are finer than this view needs, left from earlier views. They are
/// drawn until the needed blocks are resident, and while the camera moves.
Result<void> BlockTree::explore_resident_descendants() {
  const std::vector<WantedPage> wanted_pages = pages_;
  for (size_t i = 0; i < nodes_.size(); ++i) {
    const BlockNode& node = nodes_[i];
    if (node.expanded || node.key.level == 0) continue;
    if (node.resident && node.cell_px <= view_.draw_cell_px) continue;
    if (!table_.has_resident_descendant(node.key)) continue;
    if (auto expanded = expand(static_cast<int32_t>(i)); !expanded) return expanded;
  }
  pages_ = wanted_pages;
  return {};
}

void BlockTree::find_covered_blocks() {
  for (size_t i = nodes_.size(); i-- > 0;) {
    BlockNode& node = nodes_[i];
    if (!node.expanded || node.has_unknown_children) continue;
    const auto first = nodes_.begin() + node.first_child;
    node.is_covered_by_children = std::all_of(
        first, first + node.child_count, [](const BlockNode& child) { return child.is_covered(); });
  }
}

bool BlockTree::has_resident_ancestor(const BlockNode& node) const {
  for (int32_t i = node.parent; i >= 0; i = nodes_[i].parent) {
    if (nodes_[i].resident) return true;
  }
  return false;
}

Result<void> BlockTree::build() {
  if (auto refined = refine(); !refined) return refined;
  if (auto explored = explore_resident_descendants(); !explored) return explored;
  find_covered_blocks();
  return {};
}

}  // namespace isosplat
