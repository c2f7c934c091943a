#include "shared/core/preprocess/block_gather.h"

#include <algorithm>
#include <array>

namespace isosplat {
namespace {

constexpr size_t kRow = kBlockCells + 1;

Index3 first_cell_of(const GatheredBlock& block) {
  return {block.index.x * kBlockCells, block.index.y * kBlockCells, block.index.z * kBlockCells};
}

template <class T>
void gather_voxels(const Layer& layer, GatheredBlock& block) {
  const auto* voxels = reinterpret_cast<const T*>(layer.voxels);
  const Index3 first = first_cell_of(block);
  const auto row = static_cast<size_t>(block.cells.x + 1);
  QuantizedValue* to = block.voxels.data();
  for (int32_t k = 0; k <= block.cells.z; ++k) {
    for (int32_t j = 0; j <= block.cells.y; ++j, to += row) {
      std::copy_n(voxels + layer.voxel_box.at({first.x, first.y + j, first.z + k}), row, to);
    }
  }
}

template <class T>
void gather_intervals(const Layer& layer, GatheredBlock& block) {
  const auto* intervals = reinterpret_cast<const T*>(layer.intervals);
  const Index3 first = first_cell_of(block);
  CellInterval* to = block.intervals.data();
  for (int32_t k = 0; k < block.cells.z; ++k) {
    for (int32_t j = 0; j < block.cells.y; ++j) {
      const T* from = intervals + 2 * layer.cell_box.at({first.x, first.y + j, first.z + k});
      for (int32_t i = 0; i < block.cells.x; ++i, ++to) *to = {from[2 * i], from[2 * i + 1]};
    }
  }
}

/// The minimum and maximum of four rows of `count` voxels, position by position.
void combine_rows(const QuantizedValue* a, const QuantizedValue* b, const QuantizedValue* c,
                  const QuantizedValue* d, size_t count, QuantizedValue* low,
                  QuantizedValue* high) {
  for (size_t i = 0; i < count; ++i) {
    low[i] = std::min(std::min(a[i], b[i]), std::min(c[i], d[i]));
    high[i] = std::max(std::max(a[i], b[i]), std::max(c[i], d[i]));
  }
}

void find_intervals(bool has_missing, GatheredBlock& block) {
  const auto row = static_cast<size_t>(block.cells.x + 1);
  const size_t slice = row * static_cast<size_t>(block.cells.y + 1);
  const auto cells_x = static_cast<size_t>(block.cells.x);
  std::array<QuantizedValue, kRow> low, high;
  CellInterval* to = block.intervals.data();
  for (int32_t k = 0; k < block.cells.z; ++k) {
    for (int32_t j = 0; j < block.cells.y; ++j, to += cells_x) {
      const QuantizedValue* v =
          block.voxels.data() + static_cast<size_t>(k) * slice + static_cast<size_t>(j) * row;
      combine_rows(v, v + row, v + slice, v + slice + row, row, low.data(), high.data());
      for (size_t i = 0; i < cells_x; ++i) {
        to[i] = {std::min(low[i], low[i + 1]), std::max(high[i], high[i + 1])};
      }
      if (!has_missing) continue;
      for (size_t i = 0; i < cells_x; ++i) {
        if (to[i].max == kMissingVoxel) to[i] = {kMissingVoxel, 0};
      }
    }
  }
}

/// Flattens the intervals of cells that are not active at an isovalue. Intervals above it are
/// reduced to their greatest value, and those below to their least. The unions of intervals at the
/// next level stay the same, if they are active at the isovalue.
void keep_active(QuantizedValue isovalue, GatheredBlock& block) {
  for (CellInterval& cell : block.intervals) {
    if (cell.min >= cell.max) continue;
    if (cell.min > isovalue) {
      cell.min = cell.max;
    } else if (cell.max <= isovalue) {
      cell.max = cell.min;
    }
  }
}

}  // namespace

void gather_block(const Layer& layer, Index3 index, GatheredBlock& block) {
  block.index = index;
  block.cells = block_cells(layer.grid, index);
  block.voxels.resize(static_cast<size_t>(block.cells.x + 1) *
                      static_cast<size_t>(block.cells.y + 1) *
                      static_cast<size_t>(block.cells.z + 1));
  block.intervals.resize(static_cast<size_t>(block.cells.x) * static_cast<size_t>(block.cells.y) *
                         static_cast<size_t>(block.cells.z));
  layer.bits == 8 ? gather_voxels<uint8_t>(layer, block) : gather_voxels<uint16_t>(layer, block);
  if (!layer.intervals) {
    find_intervals(layer.has_missing, block);
  } else {
    layer.bits == 8 ? gather_intervals<uint8_t>(layer, block)
                    : gather_intervals<uint16_t>(layer, block);
  }
  if (layer.only_isovalue) keep_active(*layer.only_isovalue, block);
}

void find_row_intervals(GatheredBlock& block) {
  const auto across = static_cast<size_t>(block.cells.x);
  block.row_intervals.resize(block.intervals.size() / across);
  const CellInterval* cells = block.intervals.data();
  for (CellInterval& row : block.row_intervals) {
    QuantizedValue low = 65535, high = 0;
    for (size_t i = 0; i < across; ++i) {
      low = std::min(low, cells[i].min);
      high = std::max(high, cells[i].max);
    }
    row = {low, high};
    cells += across;
  }
}

}  // namespace isosplat
