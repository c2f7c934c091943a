#pragma once

#include "native/import/dicom_frames.h"
#include "native/import/volume_source.h"

// The pixels of frames: read from native and deflated files as they are, decompressed by GDCM in a
// child process where they are encapsulated.
namespace isosplat::dicom {

/// A frame, and what makes values of its pixels.
struct FramePixels {
  const Image* image = nullptr;
  uint32_t index = 0;
  double slope = 1, intercept = 0;  ///< value = intercept + slope · stored
};

/// Reads the values of frames, one after the other, as voxels of type `to` (which must be able to
/// hold them; floats take the nearest) into `out`, which has room for exactly them. `memory_bytes`:
/// what a child process may take. `fills`: pixels that a file that is cut off lacks are absent
/// (absent_voxels.h), as are its frames that cannot be decompressed; `to` is f32 or f64 then.
/// Errors: io_error, truncated, malformed_volume, out_of_memory.
Result<void> read_frames(std::span<const FramePixels> frames, VoxelType to, bool fills,
                         uint64_t memory_bytes, std::span<std::byte> out);

/// Bytes of a frame's pixels as stored.
uint64_t stored_frame_bytes(const Image& image);

/// The least and greatest stored number that an image's pixels can have.
std::pair<double, double> stored_range(const Image& image);

}  // namespace isosplat::dicom
