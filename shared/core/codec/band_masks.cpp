#include "shared/core/codec/band_masks.h"

#include "shared/core/codec/ops.h"

namespace isosplat {

void BandMasks::set(const BlockVoxels& block, uint32_t begin, std::span<const uint32_t> ends) {
  if (masks_.size() < ends.size()) masks_.resize(ends.size());
  for (size_t band = 0; band < ends.size(); ++band) masks_[band].clear();
  const CellInterval* cells = block.intervals;
  const CellInterval* row = block.row_intervals;
  for (int32_t z = 0; z < block.cells.z; ++z) {
    for (int32_t y = 0; y < block.cells.y; ++y, cells += block.cells.x, row += row != nullptr) {
      uint32_t band_begin = begin;
      for (size_t band = 0; band < ends.size(); band_begin = ends[band++]) {
        if (row && row->max <= band_begin) break;
        if (row && row->min >= ends[band]) continue;
        masks_[band].row(y, z) =
            VectorOps::active_cells(cells, block.cells.x, band_begin, ends[band]);
      }
    }
  }
}

}  // namespace isosplat
