#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "shared/core/codec/cell_mask.h"
#include "shared/core/codec/chunk_codec.h"

namespace isosplat {

/// Finds the cells of all bands of a block in one pass over the block's intervals, because these do
/// not fit the L1 and L2 caches. Keeps scratch memory: 33 KiB per band.
class BandMasks {
 public:
  /// `begin`: of the first band; `ends`: of all bands, ascending.
  void set(const BlockVoxels& block, uint32_t begin, std::span<const uint32_t> ends);

  /// The cells of a band with max(min, its begin) < min(max, its end).
  const CellMask& operator[](size_t band) const { return masks_[band]; }

 private:
  std::vector<CellMask> masks_;
};

}  // namespace isosplat
