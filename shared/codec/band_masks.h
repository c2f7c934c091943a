#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "shared/codec/cell_mask.h"
#include "shared/codec/chunk_codec.h"

namespace isosplat {

/// Which cells each band of a block holds, found in one pass over the block's intervals: they do
/// not fit the nearer caches. Keeps scratch memory: 33 KiB for each band.
class BandMasks {
 public:
  /// The bands begin with `begin`, and end at `ends`, ascending.
  void set(const BlockVoxels& block, uint32_t begin, std::span<const uint32_t> ends);

  /// The cells of a band with max(min, its begin) < min(max, its end).
  const CellMask& operator[](size_t band) const { return masks_[band]; }

 private:
  std::vector<CellMask> masks_;
};

}  // namespace isosplat
