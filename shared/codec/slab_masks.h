#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "shared/codec/cell_mask.h"
#include "shared/codec/chunk_codec.h"

namespace isosplat {

/// Which cells each slab of a block holds, found in one pass over the block's intervals: they do
/// not fit the nearer caches. Keeps scratch memory: 33 KiB for each slab.
class SlabMasks {
 public:
  /// The slabs begin with `begin`, and end at `ends`, ascending.
  void set(const BlockView& block, uint32_t begin, std::span<const uint32_t> ends);

  /// The cells of a slab with max(min, its begin) < min(max, its end).
  const CellMask& operator[](size_t slab) const { return masks_[slab]; }

 private:
  std::vector<CellMask> masks_;
};

}  // namespace isosplat
