#include "shared/codec/slab_masks.h"

#include "shared/codec/ops.h"

namespace isosplat {

void SlabMasks::set(const BlockView& block, uint32_t begin, std::span<const uint32_t> ends) {
  if (masks_.size() < ends.size()) masks_.resize(ends.size());
  for (size_t slab = 0; slab < ends.size(); ++slab) masks_[slab].clear();
  const CellInterval* cells = block.intervals;
  const CellInterval* row = block.row_intervals;
  for (int32_t z = 0; z < block.cells.z; ++z) {
    for (int32_t y = 0; y < block.cells.y; ++y, cells += block.cells.x, row += row != nullptr) {
      uint32_t slab_begin = begin;
      for (size_t slab = 0; slab < ends.size(); slab_begin = ends[slab++]) {
        if (row && row->max <= slab_begin) break;
        if (row && row->min >= ends[slab]) continue;
        masks_[slab].row(y, z) =
            VectorOps::active_cells(cells, block.cells.x, slab_begin, ends[slab]);
      }
    }
  }
}

}  // namespace isosplat
