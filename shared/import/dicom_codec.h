#pragma once

#include <span>

#include "shared/import/dicom_frames.h"

namespace isosplat::dicom {

/// Decompresses frames of encapsulated images, one after another, into `out`: stored pixels,
/// native-endian, `allocated` bits each. Runs GDCM in a child process, which may use `memory_bytes`
/// of memory. `fill_missing`: if frames of a truncated file are missing or cannot be decompressed,
/// their elements of `is_absent` (one per frame) become true; without it, such frames are errors.
/// Errors: io_error, truncated, malformed_volume, out_of_memory.
struct EncodedFrame {
  const Image* image = nullptr;
  uint32_t index = 0;
};
Result<void> decompress(std::span<const EncodedFrame> frames, bool fill_missing,
                        uint64_t memory_bytes, std::span<std::byte> out,
                        std::vector<bool>& is_absent);

}  // namespace isosplat::dicom
