#include "shared/core/adaptive/adaptive_grid.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "shared/core/grid/grid.h"

namespace isosplat {
namespace {

std::string text(Index3 v) {
  return std::to_string(v.x) + ' ' + std::to_string(v.y) + ' ' + std::to_string(v.z);
}

/// Calls visit(node, value) for all values of a box, of `size` nodes or cells along each axis.
template <class Visit>
void for_each_value(Index3 low, Index3 size, std::span<const double> values, const Visit& visit) {
  size_t i = 0;
  for (int32_t z = 0; z < size.z; ++z) {
    for (int32_t y = 0; y < size.y; ++y) {
      for (int32_t x = 0; x < size.x; ++x) visit(low + Index3{x, y, z}, values[i++]);
    }
  }
}

/// Sets the value at a position that has none yet.
void set_first(CellBrick& brick, Index3 at, double value) {
  const size_t i = CellBricks::index(at);
  if (brick.states[i] != CellState::none) return;
  if (brick.values.empty()) brick.values.resize(kBrickVolume);
  brick.values[i] = value;
  brick.states[i] = std::isfinite(value) ? CellState::leaf : CellState::hole;
}

/// The same for a cell of a grid with values at nodes.
void set_first_state(CellBrick& brick, Index3 cell, bool has_value) {
  CellState& state = brick.states[CellBricks::index(cell)];
  if (state == CellState::none) state = has_value ? CellState::leaf : CellState::hole;
}

Index3 corner(int32_t octant) {
  return {octant & 1, octant >> 1 & 1, octant >> 2};
}

}  // namespace

Result<AdaptiveGrid> AdaptiveGrid::create(Index3 cells, std::span<const int32_t> ratios,
                                          Centring centring, uint64_t memory_bytes) {
  if (std::min({cells.x, cells.y, cells.z}) < 1 || ratios.size() >= kMaxRefinementLevels) {
    return fail(Status::invalid_argument,
                "an adaptive grid: expected cells along each axis and at most " +
                    std::to_string(kMaxRefinementLevels) + " refinement levels, found " +
                    text(cells) + " and " + std::to_string(ratios.size() + 1));
  }
  Vec3<int64_t> finest{cells.x, cells.y, cells.z};
  for (const int32_t ratio : ratios) {
    if (ratio < 2 || ratio > kMaxRefinement) {
      return fail(Status::invalid_argument,
                  "an adaptive grid: expected a ratio between refinement levels from 2 to " +
                      std::to_string(kMaxRefinement) + ", found " + std::to_string(ratio));
    }
    const bool is_large = std::max({finest.x, finest.y, finest.z}) >= kMaxVoxelsPerAxis;
    if (!is_large) finest = finest * int64_t{ratio};
  }
  if (std::max({finest.x, finest.y, finest.z}) >= kMaxVoxelsPerAxis) {
    return fail(Status::volume_too_large,
                "an adaptive grid: expected fewer than " + std::to_string(kMaxVoxelsPerAxis) +
                    " cells of the finest level along each axis, found more");
  }
  AdaptiveGrid grid;
  grid.cells_ = cells;
  grid.ratios_.assign(ratios.begin(), ratios.end());
  grid.levels_.resize(ratios.size() + 1);
  grid.centring_ = centring;
  grid.limit_ = memory_bytes;
  return grid;
}

int32_t AdaptiveGrid::cells_per_edge(uint32_t coarse, uint32_t fine) const {
  int32_t cells = 1;
  for (uint32_t level = coarse; level < fine; ++level) cells *= ratios_[level];
  return cells;
}

Index3 AdaptiveGrid::cells(uint32_t level) const {
  return cells_ * cells_per_edge(0, level);
}

bool AdaptiveGrid::is_inside(uint32_t level, Index3 cell) const {
  const Index3 n = cells(level);
  return cell.x >= 0 && cell.y >= 0 && cell.z >= 0 && cell.x < n.x && cell.y < n.y && cell.z < n.z;
}

Result<void> AdaptiveGrid::reserve(const CellBricks& bricks, const CellBox& box,
                                   uint64_t brick_bytes) {
  uint64_t needed = 0;
  for (int32_t z = box.low.z & ~7; z < box.high.z; z += kBrickCells) {
    for (int32_t y = box.low.y & ~7; y < box.high.y; y += kBrickCells) {
      for (int32_t x = box.low.x & ~7; x < box.high.x; x += kBrickCells) {
        if (!bricks.find({x, y, z})) needed += brick_bytes;
        if (bytes_ + needed > limit_) return take(needed);
      }
    }
  }
  return take(needed);
}

Result<void> AdaptiveGrid::take(uint64_t bytes) {
  if (bytes_ + bytes > limit_) {
    return fail(Status::out_of_memory,
                "an adaptive grid: expected patches whose cells need at most " +
                    std::to_string(limit_ >> 20) + " MiB of memory, found more: give more memory");
  }
  bytes_ += bytes;
  return {};
}

/// Adds a cell whose nodes are all in one brick.
Result<void> AdaptiveGrid::add_cell(Level& to, Index3 cell, std::span<const double> values) {
  CellBrick* cells = to.cells.find(cell);
  CellBrick* nodes = to.nodes.find(cell);
  if (auto fits = take((cells ? 0 : cell_brick_bytes()) + (nodes ? 0 : kBrickBytes)); !fits)
    return fits;
  if (!cells) cells = &to.cells.at(cell);
  if (!nodes) nodes = &to.nodes.at(cell);
  bool has_all = true;
  for (int32_t i = 0; i < 8; ++i) {
    const double value = values[static_cast<size_t>(i)];
    if (std::isfinite(value)) {
      set_first(*nodes, cell + corner(i), value);
    } else {
      has_all = false;
    }
  }
  set_first_state(*cells, cell, has_all);
  return {};
}

Result<void> AdaptiveGrid::add(uint32_t level, const CellBox& box, std::span<const double> values) {
  const Index3 size{box.high.x - box.low.x, box.high.y - box.low.y, box.high.z - box.low.z};
  const bool is_box = std::min({size.x, size.y, size.z}) > 0;
  if (level >= levels() || !is_box || !is_inside(level, box.low) ||
      !is_inside(level, box.high - Index3{1, 1, 1})) {
    return fail(Status::malformed_volume, "a patch of refinement level " + std::to_string(level) +
                                              ": expected cells of the domain, found those from " +
                                              text(box.low) + " to " +
                                              text(box.high - Index3{1, 1, 1}));
  }
  Level& to = levels_[level];
  const auto is_before_last = [](int32_t at) { return at % kBrickCells < kBrickCells - 1; };
  if (centring_ == Centring::nodes && box.cells() == 1 && is_before_last(box.low.x) &&
      is_before_last(box.low.y) && is_before_last(box.low.z)) {
    return add_cell(to, box.low, values);
  }
  if (auto fits = reserve(to.cells, box); !fits) return fits;
  if (centring_ == Centring::cells) {
    for_each_value(box.low, size, values,
                   [&](Index3 cell, double value) { set_first(to.cells.at(cell), cell, value); });
    return {};
  }
  const Index3 nodes = size + Index3{1, 1, 1};
  if (auto fits = reserve(to.nodes, {box.low, box.low + nodes}, kBrickBytes); !fits) return fits;
  const auto value_at = [&](Index3 node) {
    return values[(static_cast<size_t>(node.z) * static_cast<size_t>(nodes.y) +
                   static_cast<size_t>(node.y)) *
                      static_cast<size_t>(nodes.x) +
                  static_cast<size_t>(node.x)];
  };
  for_each_value(box.low, nodes, values, [&](Index3 node, double value) {
    if (std::isfinite(value)) set_first(to.nodes.at(node), node, value);
  });
  for (int32_t z = box.low.z; z < box.high.z; ++z) {
    for (int32_t y = box.low.y; y < box.high.y; ++y) {
      for (int32_t x = box.low.x; x < box.high.x; ++x) {
        const Index3 cell{x, y, z};
        bool has_all = true;
        for (int32_t i = 0; i < 8; ++i) {
          has_all = has_all && std::isfinite(value_at(cell - box.low + corner(i)));
        }
        set_first_state(to.cells.at(cell), cell, has_all);
      }
    }
  }
  return {};
}

void AdaptiveGrid::add_level(int32_t ratio) {
  ratios_.push_back(ratio);
  levels_.emplace_back();
}

}  // namespace isosplat
