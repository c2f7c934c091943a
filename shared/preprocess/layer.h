#pragma once

#include <cstddef>
#include <cstdint>

#include "shared/grid/grid.h"

namespace isosplat {

/// The part of a level that a layer of blocks needs: slices of voxels, and at coarser levels slices
/// of cell intervals, x fastest. Quantized values have `bits` bits; an interval is two quantized
/// values, min and max. Borrows the memory.
struct Layer {
  LevelGrid grid;
  uint8_t bits = 16;
  bool has_missing = false;
  const std::byte* voxels = nullptr;  ///< from slice first_voxel_slice on
  int32_t first_voxel_slice = 0;
  const std::byte* intervals = nullptr;  ///< from slice first_cell_slice on; null at level 0
  int32_t first_cell_slice = 0;
};

/// The memory for the part of the next coarser level that covers a layer, in the same form.
struct CoarserLayer {
  LevelGrid grid;
  std::byte* voxels = nullptr;  ///< null: there is no coarser level
  int32_t first_voxel_slice = 0;
  std::byte* intervals = nullptr;
  int32_t first_cell_slice = 0;
};

/// Bytes of one slice of a level's voxels and cell intervals.
inline size_t voxel_slice_bytes(const LevelGrid& grid, uint8_t bits) {
  return static_cast<size_t>(grid.cells.x + 1) * static_cast<size_t>(grid.cells.y + 1) * bits / 8;
}
inline size_t interval_slice_bytes(const LevelGrid& grid, uint8_t bits) {
  return static_cast<size_t>(grid.cells.x) * static_cast<size_t>(grid.cells.y) * bits / 4;
}

}  // namespace isosplat
