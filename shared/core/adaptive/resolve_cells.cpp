#include "shared/core/adaptive/adaptive_grid.h"

// Finds the leaf cells of overlapping patches: from the finest level to the coarsest, which cells
// are full, then from the coarsest to the finest, which cells are valid.
namespace isosplat {
namespace {

/// Calls visit(cell) for the cells of the next finer level in a cell.
template <class Visit>
void for_each_child(Index3 cell, int32_t ratio, const Visit& visit) {
  const Index3 low = cell * ratio;
  for (int32_t z = 0; z < ratio; ++z) {
    for (int32_t y = 0; y < ratio; ++y) {
      for (int32_t x = 0; x < ratio; ++x) visit(low + Index3{x, y, z});
    }
  }
}

bool has_data(CellState state) {
  return state != CellState::none;
}

/// Counts for each cell of a level the children that are full: those in a patch, and those whose
/// own children are all full.
void count_full_children(CellBricks& parents, const CellBricks& children, int32_t ratio,
                         int32_t next_ratio) {
  const auto whole = static_cast<uint16_t>(next_ratio * next_ratio * next_ratio);
  for (const auto& [key, brick] : children) {
    for (size_t i = 0; i < kBrickVolume; ++i) {
      if (!has_data(brick.states[i]) && !brick.has_children[i]) continue;
      const Index3 child = cell_of(brick, i);
      const Index3 parent{child.x / ratio, child.y / ratio, child.z / ratio};
      CellBrick& to = parents.at(parent);
      const size_t k = CellBricks::index(parent);
      to.has_children.set(k);
      const bool is_full =
          has_data(brick.states[i]) || (!brick.covered.empty() && brick.covered[i] == whole);
      if (!is_full) continue;
      if (to.covered.empty()) to.covered.resize(kBrickVolume);
      ++to.covered[k];
    }
  }
}

/// Drops all finer cells in a cell. Returns the number of those with data.
uint64_t drop_children(AdaptiveGrid& grid, uint32_t level, Index3 cell) {
  uint64_t dropped = 0;
  for_each_child(cell, grid.ratio(level), [&](Index3 child) {
    CellBrick* const brick = grid.bricks(level + 1).find(child);
    if (!brick) return;
    const size_t i = CellBricks::index(child);
    if (has_data(brick->states[i])) ++dropped;
    brick->states[i] = CellState::none;
    if (!brick->has_children[i]) return;
    brick->has_children.reset(i);
    dropped += drop_children(grid, level + 1, child);
  });
  return dropped;
}

}  // namespace

uint64_t AdaptiveGrid::resolve() {
  for (uint32_t level = levels() - 1; level > 0; --level) {
    const int32_t next_ratio = level + 1 < levels() ? ratio(level) : 0;
    count_full_children(bricks(level - 1), bricks(level), ratio(level - 1), next_ratio);
  }
  uint64_t dropped = 0;
  for (uint32_t level = 0; level < levels(); ++level) {
    const int32_t r = level + 1 < levels() ? ratio(level) : 0;
    for (auto& [key, brick] : bricks(level)) {
      for (size_t i = 0; i < kBrickVolume; ++i) {
        if (!brick.has_children[i]) continue;
        if (!has_data(brick.states[i]) ||
            (!brick.covered.empty() && brick.covered[i] == r * r * r)) {
          brick.states[i] = CellState::refined;
        } else {
          dropped += drop_children(*this, level, cell_of(brick, i));
        }
      }
      brick.covered = {};
      brick.has_children.reset();
    }
  }
  return dropped;
}

}  // namespace isosplat
