#pragma once

#include <span>
#include <vector>

#include "shared/core/grid/volume_source.h"

namespace isosplat {

/// Consecutive slices of a volume as values (after slope and intercept) in single precision. NaN:
/// no value. Slices that two windows share are read once. Borrows the volume.
class SliceWindow {
 public:
  explicit SliceWindow(VolumeSource& volume) : volume_(volume) {}

  /// Bytes of one slice in the window, and the most while it is read.
  uint64_t slice_bytes() const;

  /// Holds slices [first, end) from now on, 0 ≤ first < end ≤ nz. Errors: those of the volume.
  Result<void> move_to(int32_t first, int32_t end);

  /// Requires that the window holds slice z.
  float at(int32_t x, int32_t y, int32_t z) const {
    const Index3 n = volume_.header().grid.voxels;
    return values_[(static_cast<size_t>(z - first_) * static_cast<size_t>(n.y) +
                    static_cast<size_t>(y)) *
                       static_cast<size_t>(n.x) +
                   static_cast<size_t>(x)];
  }

 private:
  size_t slice_voxels() const;
  Result<void> read(int32_t first, int32_t end, float* values);

  VolumeSource& volume_;
  int32_t first_ = 0, end_ = 0;
  std::vector<float> values_;
  std::vector<std::byte> voxels_;
};

}  // namespace isosplat
