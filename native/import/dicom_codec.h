#pragma once

#include <span>

#include "native/import/dicom_frames.h"

namespace isosplat::dicom {

/// Decompresses frames of encapsulated images, one after the other, into `out`: pixels as they are
/// stored, native-endian, `allocated` bits each. Runs GDCM in a child process that may take
/// `memory_bytes`. `fills`: where frames of a file that is cut off are not there or cannot be
/// decompressed, `is_absent`, one for each frame, becomes true; else such frames are errors.
/// Errors: io_error, truncated, malformed_volume, out_of_memory.
struct EncodedFrame {
  const Image* image = nullptr;
  uint32_t index = 0;
};
Result<void> decompress(std::span<const EncodedFrame> frames, bool fills, uint64_t memory_bytes,
                        std::span<std::byte> out, std::vector<bool>& is_absent);

}  // namespace isosplat::dicom
