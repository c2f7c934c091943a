#pragma once

#include "shared/core/grid/volume_source.h"
#include "shared/import/dicom/frames.h"

// Reads the pixels of frames: directly from native and deflated files; encapsulated pixels are
// decompressed by codec.h.
namespace isosplat::import::dicom {

/// A frame, and the mapping from its pixels to values.
struct FramePixels {
  const Image* image = nullptr;
  uint32_t index = 0;
  uint32_t tile = 0;                ///< of a mosaic: the slice in the frame
  double slope = 1, intercept = 0;  ///< value = intercept + slope · stored
  std::optional<int> label;         ///< value = 1 where the stored pixel is this number, else 0
};

/// Reads the values of frames, one after another, as voxels of type `to` into `out`. `to` must be
/// able to represent the values; floating-point types round to nearest. `out` has exactly the size
/// of the frames' voxels. `memory_bytes`: the memory limit of the child process. With
/// `fill_missing`, missing pixels of a truncated file, and frames of it that cannot be
/// decompressed, become absent (voxels/absent_voxels.h); `to` must then be f32 or f64. Errors:
/// io_error, truncated, malformed_volume, out_of_memory.
Result<void> read_frames(std::span<const FramePixels> frames, VoxelType to, bool fill_missing,
                         uint64_t memory_bytes, std::span<std::byte> out);

/// Size of a frame's stored pixels in bytes. Pixels of 1 bit count as bytes: they are unpacked.
uint64_t stored_frame_bytes(const Image& image);

/// The smallest and largest stored number that an image's pixels can have.
std::pair<double, double> stored_range(const Image& image);

}  // namespace isosplat::import::dicom
