#include "shared/core/adaptive/node_values.h"

#include <algorithm>
#include <array>

namespace isosplat {
namespace {

using Leaves = std::array<std::optional<LeafCell>, 8>;

Index3 offset(int32_t octant) {
  return {octant & 1, octant >> 1 & 1, octant >> 2};
}

bool is_multiple(Index3 node, int32_t cells) {
  return node.x % cells == 0 && node.y % cells == 0 && node.z % cells == 0;
}

Index3 divided(Index3 node, int32_t cells) {
  return {node.x / cells, node.y / cells, node.z / cells};
}

/// The average of the cells around a node, weighted by the inverse of their edges. `coarsest`: of
/// their levels. A cell in the octant with the signs s has its centre at s · edge / 2 from the
/// node, so the weighted sum of these offsets is the sum of the signs: 0 if all octants have cells.
/// Then linear functions are exact. With weights by volume, the node of a plane between two levels
/// of ratio 2 would have the value of a point 0.42 coarse cells away.
double average(const AdaptiveGrid& grid, const Leaves& leaves, uint32_t coarsest) {
  double sum = 0, weights = 0;
  for (const auto& leaf : leaves) {
    if (!leaf) continue;
    const double weight = grid.cells_per_edge(coarsest, leaf->level);
    sum += weight * grid.cell_value(leaf->level, leaf->cell);
    weights += weight;
  }
  return sum / weights;
}

/// The value of the finest patch at a node of level `level`.
double finest(const AdaptiveGrid& grid, const Leaves& leaves, uint32_t level, Index3 node) {
  uint32_t best = level;
  for (const auto& leaf : leaves) {
    if (leaf) best = std::max(best, leaf->level);
  }
  return grid.node_value(best, node * grid.cells_per_edge(level, best));
}

/// What a leaf cell interpolates at a node of level `level`.
double interpolated(const AdaptiveGrid& grid, const LeafCell& leaf, uint32_t level, Index3 node) {
  const int32_t cells = grid.cells_per_edge(leaf.level, level);
  const Index3 inside = node - leaf.cell * cells;
  const auto along = [cells](double a, double b, int32_t at) {
    return at == 0 ? a : at == cells ? b : a + (b - a) * at / cells;
  };
  // Corners that do not contribute are not computed: they may not be needed for any other node.
  const auto corner = [&](int32_t octant) {
    const Index3 o = offset(octant);
    const bool is_unused = (o.x ? inside.x == 0 : inside.x == cells) ||
                           (o.y ? inside.y == 0 : inside.y == cells) ||
                           (o.z ? inside.z == 0 : inside.z == cells);
    return is_unused ? 0 : node_value(grid, leaf.level, leaf.cell + o);
  };
  const auto edge = [&](int32_t first) {
    return along(corner(first), corner(first + 1), inside.x);
  };
  const auto face = [&](int32_t first) { return along(edge(first), edge(first + 2), inside.y); };
  return along(face(0), face(4), inside.z);
}

}  // namespace

std::optional<LeafCell> leaf_around(const AdaptiveGrid& grid, uint32_t level, Index3 node,
                                    int32_t octant) {
  const Index3 toward = offset(octant) - Index3{1, 1, 1};
  Index3 cell = node + toward;
  if (!grid.is_inside(level, cell)) return std::nullopt;
  CellState state = grid.bricks(level).state(cell);
  while (state == CellState::none && level > 0) {
    cell = divided(cell, grid.ratio(--level));
    state = grid.bricks(level).state(cell);
    if (state == CellState::refined) return std::nullopt;  // its children do not fill it
  }
  while (state == CellState::refined) {
    node = node * grid.ratio(level++);
    cell = node + toward;
    state = grid.bricks(level).state(cell);
  }
  if (state != CellState::leaf) return std::nullopt;
  return LeafCell{level, cell};
}

double node_value(const AdaptiveGrid& grid, uint32_t level, Index3 node) {
  Leaves leaves;
  const LeafCell* coarsest = nullptr;
  for (int32_t octant = 0; octant < 8; ++octant) {
    auto& leaf = leaves[static_cast<size_t>(octant)];
    leaf = leaf_around(grid, level, node, octant);
    if (leaf && (!coarsest || leaf->level < coarsest->level)) coarsest = &*leaf;
  }
  if (coarsest->level < level) {
    const int32_t cells = grid.cells_per_edge(coarsest->level, level);
    if (!is_multiple(node, cells)) return interpolated(grid, *coarsest, level, node);
    level = coarsest->level;
    node = divided(node, cells);
  }
  if (grid.centring() == Centring::nodes) return finest(grid, leaves, level, node);
  return average(grid, leaves, level);
}

}  // namespace isosplat
