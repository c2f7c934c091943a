#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "shared/core/grid/grid.h"

namespace isosplat {

/// A box of a level's voxels or cells that is in memory, x fastest.
struct LevelBox {
  Index3 first;
  Index3 size;

  /// The index of a voxel or cell of the level in the memory of the box.
  size_t at(Index3 p) const {
    const Index3 q{p.x - first.x, p.y - first.y, p.z - first.z};
    return (static_cast<size_t>(q.z) * static_cast<size_t>(size.y) + static_cast<size_t>(q.y)) *
               static_cast<size_t>(size.x) +
           static_cast<size_t>(q.x);
  }
  /// The position behind the last one along each axis.
  Index3 end() const { return {first.x + size.x, first.y + size.y, first.z + size.z}; }
  size_t count() const {
    return static_cast<size_t>(size.x) * static_cast<size_t>(size.y) * static_cast<size_t>(size.z);
  }
};

/// The slices [first, first + count) of a level's voxels, and of its cells.
inline LevelBox voxel_slices(const LevelGrid& grid, int32_t first, int32_t count) {
  return {{0, 0, first}, {grid.cells.x + 1, grid.cells.y + 1, count}};
}
inline LevelBox cell_slices(const LevelGrid& grid, int32_t first, int32_t count) {
  return {{0, 0, first}, {grid.cells.x, grid.cells.y, count}};
}

/// Rows of blocks of a layer, [first, end) along y: a band.
struct BlockRows {
  int32_t first = 0, end = 0;
  int32_t count() const { return end - first; }
};

/// The voxels before a block that coarsening it needs, along each axis.
inline constexpr int32_t kVoxelsBefore = 2;

class CoarseLevels;

/// The part of a level that one or more blocks need: voxels, and at coarser levels cell intervals.
/// Quantized values have `bits` bits; an interval is two quantized values, min and max. Borrows the
/// memory. Gathering a block needs its voxels and cells. Coarsening it also needs kVoxelsBefore
/// voxels before the block along each axis, as far as there are any.
struct Layer {
  LevelGrid grid;
  uint8_t bits = 16;
  bool has_missing = false;
  const std::byte* voxels = nullptr;
  LevelBox voxel_box = {};
  const std::byte* intervals = nullptr;  ///< null at level 0
  LevelBox cell_box = {};
  /// If set, cells that are not active at this quantized isovalue count as flat.
  std::optional<QuantizedValue> only_isovalue = {};
  const CoarseLevels* coarse_levels = nullptr;  ///< null: averages (coarsen_block)
};

/// The memory for the part of the next coarser level that covers a layer, in the same form.
struct CoarserLayer {
  LevelGrid grid;
  std::byte* voxels = nullptr;  ///< null: there is no coarser level
  LevelBox voxel_box = {};
  std::byte* intervals = nullptr;
  LevelBox cell_box = {};
};

}  // namespace isosplat
