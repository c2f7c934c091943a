#include "shared/core/adaptive/drawn_cells.h"

#include <algorithm>
#include <tuple>
#include <vector>

namespace isosplat {
namespace {

Index3 offset(int32_t octant) {
  return {octant & 1, octant >> 1 & 1, octant >> 2};
}

bool is_drawn(const AdaptiveGrid& grid, uint32_t level, Index3 cell) {
  return grid.is_inside(level, cell) && grid.bricks(level).is_drawn(cell);
}

/// The number of drawn cells around a node.
int32_t drawn_around(const AdaptiveGrid& grid, uint32_t level, Index3 node) {
  int32_t count = 0;
  for (int32_t octant = 0; octant < 8; ++octant) {
    count += is_drawn(grid, level, node - Index3{1, 1, 1} + offset(octant)) ? 1 : 0;
  }
  return count;
}

/// Draws a cell on the next finer level.
Result<void> refine(AdaptiveGrid& grid, uint32_t level, Index3 cell) {
  if (level + 1 == grid.levels()) grid.add_level(2);
  const int32_t ratio = grid.ratio(level);
  CellBricks& finer = grid.bricks(level + 1);
  const Index3 low = cell * ratio;
  if (auto fits = grid.reserve(finer, {low, low + Index3{ratio, ratio, ratio}}); !fits) return fits;
  for (int32_t z = 0; z < ratio; ++z) {
    for (int32_t y = 0; y < ratio; ++y) {
      for (int32_t x = 0; x < ratio; ++x) {
        const Index3 child = low + Index3{x, y, z};
        finer.at(child).drawn.set(CellBricks::index(child));
      }
    }
  }
  grid.bricks(level).find(cell)->drawn.reset(CellBricks::index(cell));
  return {};
}

/// Frees the corner of a cell that the fewest drawn cells need, if they need all its corners.
Result<void> free_corner(AdaptiveGrid& grid, uint32_t level, Index3 cell) {
  int32_t fewest = 8;
  Index3 corner;
  for (int32_t octant = 0; octant < 8; ++octant) {
    const Index3 node = cell + offset(octant);
    const int32_t needed = drawn_around(grid, level, node);
    if (needed == 0) return {};
    if (needed < fewest) {
      fewest = needed;
      corner = node;
    }
  }
  for (int32_t octant = 0; octant < 8; ++octant) {
    const Index3 around = corner - Index3{1, 1, 1} + offset(octant);
    if (!is_drawn(grid, level, around)) continue;
    if (auto refined = refine(grid, level, around); !refined) return refined;
  }
  return {};
}

/// Frees corners of cells in and around a brick.
Result<void> free_corners(AdaptiveGrid& grid, uint32_t level, const CellBrick& brick) {
  const Index3 first = brick.first;
  for (int32_t z = -1; z <= kBrickCells; ++z) {
    for (int32_t y = -1; y <= kBrickCells; ++y) {
      for (int32_t x = -1; x <= kBrickCells; ++x) {
        const Index3 cell = first + Index3{x, y, z};
        if (!grid.is_inside(level, cell) || grid.bricks(level).is_drawn(cell)) continue;
        if (auto freed = free_corner(grid, level, cell); !freed) return freed;
      }
    }
  }
  return {};
}

}  // namespace

Result<void> choose_drawn_cells(AdaptiveGrid& grid) {
  for (uint32_t level = 0; level < grid.levels(); ++level) {
    for (auto& [key, brick] : grid.bricks(level)) {
      for (size_t i = 0; i < kBrickVolume; ++i) brick.drawn[i] = brick.states[i] == CellState::leaf;
    }
  }
  // From the coarsest level: a level has all cells that coarser levels give it before it is read.
  for (uint32_t level = 0; level < grid.levels(); ++level) {
    std::vector<const CellBrick*> bricks;
    for (const auto& [key, brick] : grid.bricks(level)) {
      if (brick.drawn.any()) bricks.push_back(&brick);
    }
    // The order of the table may differ between implementations of it.
    std::sort(bricks.begin(), bricks.end(), [](const CellBrick* a, const CellBrick* b) {
      return std::tie(a->first.z, a->first.y, a->first.x) <
             std::tie(b->first.z, b->first.y, b->first.x);
    });
    for (const CellBrick* const brick : bricks) {
      if (auto freed = free_corners(grid, level, *brick); !freed) return freed;
    }
  }
  return {};
}

}  // namespace isosplat
