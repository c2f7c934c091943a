#include "shared/core/adaptive/level_source.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "shared/core/adaptive/node_values.h"

namespace isosplat {
namespace {

constexpr uint8_t kDrawn = 1;
constexpr uint8_t kIsLeaf = 2;

/// The bounding box of the drawn cells. Empty if there are none.
CellBox drawn_box(const CellBricks& bricks) {
  constexpr int32_t kMost = std::numeric_limits<int32_t>::max();
  CellBox box{{kMost, kMost, kMost}, {0, 0, 0}};
  for (const auto& [key, brick] : bricks) {
    for (size_t i = 0; i < kBrickVolume; ++i) {
      if (!brick.drawn[i]) continue;
      const Index3 cell = cell_of(brick, i);
      box.low = {std::min(box.low.x, cell.x), std::min(box.low.y, cell.y),
                 std::min(box.low.z, cell.z)};
      box.high = {std::max(box.high.x, cell.x + 1), std::max(box.high.y, cell.y + 1),
                  std::max(box.high.z, cell.z + 1)};
    }
  }
  return box;
}

}  // namespace

std::optional<LevelSource> LevelSource::create(const AdaptiveGrid& grid, uint32_t level,
                                               const VolumeHeader& header) {
  const CellBox box = drawn_box(grid.bricks(level));
  if (box.high.x == 0) return std::nullopt;
  LevelSource source(grid);
  source.level_ = level;
  source.low_ = box.low;
  source.header_ = header;
  source.header_.type = VoxelType::f64;
  source.header_.slope = 1;
  source.header_.intercept = 0;
  VolumeGrid& to = source.header_.grid;
  const double cells = grid.cells_per_edge(0, level);
  to.voxels = box.high - box.low + Index3{1, 1, 1};
  to.spacing = header.grid.spacing * (1 / cells);
  to.origin = header.grid.world({box.low.x / cells, box.low.y / cells, box.low.z / cells});
  return source;
}

/// Reads the cells of a layer brick by brick.
void LevelSource::read_layer(int32_t z, Layer& layer) const {
  const Index3 n = header_.grid.voxels + Index3{1, 1, 1};
  const Index3 first = low_ - Index3{1, 1, 1};
  const size_t size = static_cast<size_t>(n.x) * static_cast<size_t>(n.y);
  layer.z = z;
  layer.values.assign(size, 0);
  layer.flags.assign(size, 0);
  const Index3 domain = grid_->cells(level_);
  if (z < 0 || z >= domain.z) return;
  const bool are_cells = grid_->centring() == Centring::cells;
  const int32_t low_x = std::max(first.x, 0), high_x = std::min(first.x + n.x, domain.x);
  const int32_t low_y = std::max(first.y, 0), high_y = std::min(first.y + n.y, domain.y);
  for (int32_t by = low_y & ~7; by < high_y; by += kBrickCells) {
    for (int32_t bx = low_x & ~7; bx < high_x; bx += kBrickCells) {
      const CellBrick* const brick = grid_->bricks(level_).find({bx, by, z});
      if (!brick) continue;
      for (int32_t y = std::max(by, low_y); y < std::min(by + kBrickCells, high_y); ++y) {
        for (int32_t x = std::max(bx, low_x); x < std::min(bx + kBrickCells, high_x); ++x) {
          const size_t i = CellBricks::index({x, y, z});
          const size_t to = static_cast<size_t>(y - first.y) * static_cast<size_t>(n.x) +
                            static_cast<size_t>(x - first.x);
          if (brick->drawn[i]) layer.flags[to] |= kDrawn;
          if (brick->states[i] != CellState::leaf) continue;
          layer.flags[to] |= kIsLeaf;
          if (are_cells) layer.values[to] = brick->values[i];
        }
      }
    }
  }
}

void LevelSource::read_slice(int32_t z, double* out) {
  const int32_t cell = low_.z + z;
  if (below_.z != cell - 1) {
    if (above_.z == cell - 1) {
      std::swap(below_, above_);
    } else {
      read_layer(cell - 1, below_);
    }
  }
  if (above_.z != cell) read_layer(cell, above_);
  const bool are_cells = grid_->centring() == Centring::cells;
  const Index3 n = header_.grid.voxels;
  const auto row = static_cast<size_t>(n.x) + 1;
  for (int32_t y = 0; y < n.y; ++y) {
    for (int32_t x = 0; x < n.x; ++x, ++out) {
      const size_t at = static_cast<size_t>(y) * row + static_cast<size_t>(x);
      uint8_t any = 0, all = kIsLeaf;
      double sum = 0;
      for (const Layer* const layer : {&below_, &above_}) {
        for (const size_t i : {at, at + 1, at + row, at + row + 1}) {
          any |= layer->flags[i];
          all &= layer->flags[i];
          sum += layer->values[i];
        }
      }
      if (!(any & kDrawn)) {
        *out = std::numeric_limits<double>::quiet_NaN();
      } else if (all & kIsLeaf) {  // as node_value(), without a search for the cells around
        *out = are_cells ? sum / 8 : grid_->node_value(level_, low_ + Index3{x, y, z});
      } else {
        *out = node_value(*grid_, level_, low_ + Index3{x, y, z});
      }
    }
  }
}

Result<void> LevelSource::read_slices(int32_t first, int32_t count, std::span<std::byte> out) {
  const Index3 n = header_.grid.voxels;
  const size_t slice = static_cast<size_t>(n.x) * static_cast<size_t>(n.y);
  auto* const voxels = reinterpret_cast<double*>(out.data());
  for (int32_t z = 0; z < count; ++z) {
    read_slice(first + z, voxels + slice * static_cast<size_t>(z));
  }
  return {};
}

uint64_t LevelSource::resident_bytes() const {
  const Index3 n = header_.grid.voxels + Index3{1, 1, 1};
  const auto cells = static_cast<uint64_t>(n.x) * static_cast<uint64_t>(n.y);
  return grid_->memory_bytes() + 2 * cells * (sizeof(double) + 1);
}

}  // namespace isosplat
