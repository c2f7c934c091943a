#pragma once

#include <span>
#include <vector>

#include "shared/core/grid/volume_source.h"

namespace isosplat {

/// Slices [first, end).
struct Slices {
  int32_t first = 0, end = 0;

  int32_t count() const { return end - first; }
};

/// Consecutive slices of a volume as values (after slope and intercept). NaN: no value. Slices that
/// two windows share are read once. Borrows the volume.
class SliceWindow {
 public:
  explicit SliceWindow(VolumeSource& volume) : volume_(volume) {}

  /// Bytes of one slice in the window.
  uint64_t slice_bytes() const { return slice_voxels() * sizeof(double); }

  /// Memory while windows of this many slices move: two of them, and a slice as it is read.
  uint64_t memory_bytes(int32_t slices) const {
    return slice_bytes() * static_cast<uint64_t>(2 * slices + 1);
  }

  /// Holds these slices from now on, 0 ≤ first < end ≤ nz. Errors: those of the volume.
  Result<void> move_to(Slices slices);

  /// Requires that the window holds slice z.
  double at(int32_t x, int32_t y, int32_t z) const {
    const Index3 n = volume_.header().grid.voxels;
    return values_[(static_cast<size_t>(z - held_.first) * static_cast<size_t>(n.y) +
                    static_cast<size_t>(y)) *
                       static_cast<size_t>(n.x) +
                   static_cast<size_t>(x)];
  }

 private:
  size_t slice_voxels() const;
  Result<void> read(Slices slices, double* values);

  VolumeSource& volume_;
  Slices held_;
  std::vector<double> values_;
  std::vector<std::byte> voxels_;
};

}  // namespace isosplat
