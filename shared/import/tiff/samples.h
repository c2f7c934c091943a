#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "shared/core/grid/voxel_type.h"

namespace isosplat::import {

/// The storage of samples in the rows of a page: numbers of 1 to 64 bits, each pixel's `per_pixel`
/// samples one after the other. Numbers that do not fill bytes are packed from the highest bit on,
/// and rows begin at byte boundaries (TIFF 6.0, BitsPerSample; Photoshop TIFF Technical Note 3 for
/// floating-point numbers of 16 and 24 bits).
struct TiffSamples {
  unsigned bits = 8;
  bool is_float = false, is_signed = false;
  unsigned per_pixel = 1;

  /// Bytes of a row with this many pixels.
  uint64_t row_bytes(uint64_t pixels) const { return (pixels * per_pixel * bits + 7) / 8; }

  /// Whether rows are voxels of a VoxelType, in native byte order.
  bool are_voxels() const {
    const bool is_half = is_float && bits == 16;
    return per_pixel == 1 && !is_half && (bits == 8 || bits == 16 || bits == 32 || bits == 64);
  }

  bool operator==(const TiffSamples&) const = default;
};

/// Converts sample `sample` of each pixel of a row to voxels. `row`: row_bytes bytes, with numbers
/// of 16, 24, 32 and 64 bits in native byte order. `type`: the type that set_voxel_type chooses for
/// these bits.
void unpack_row(const TiffSamples& samples, unsigned sample, std::span<const std::byte> row,
                VoxelType type, std::span<std::byte> voxels);

}  // namespace isosplat::import
