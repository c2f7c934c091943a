#pragma once

#include <functional>
#include <span>

#include "shared/import/bytes/byte_reader.h"
#include "shared/import/dicom/fragments.h"
#include "shared/import/dicom/frames.h"

namespace isosplat::import::dicom {

struct EncodedFrame {
  const Image* image = nullptr;
  uint32_t index = 0;
};

/// Decompresses frames of encapsulated images, one after another, into `out`: stored pixels,
/// native-endian, `allocated` bits each. `fill_missing`: if frames of a truncated file are missing
/// or cannot be decompressed, their elements of `is_absent` (one per frame) become true; without
/// it, such frames are errors. `memory_bytes`: limits a child process. Errors: io_error, truncated,
/// malformed_volume, unsupported_format, out_of_memory.
Result<void> decompress(std::span<const EncodedFrame> frames, bool fill_missing,
                        uint64_t memory_bytes, std::span<std::byte> out,
                        std::vector<bool>& is_absent);

/// The two implementations of decompress: with GDCM, in a child process; and without a library, for
/// WebAssembly, for run lengths and lossless JPEG.
Result<void> decompress_with_gdcm(std::span<const EncodedFrame> frames, bool fill_missing,
                                  uint64_t memory_bytes, std::span<std::byte> out,
                                  std::vector<bool>& is_absent);
Result<void> decompress_plainly(std::span<const EncodedFrame> frames, bool fill_missing,
                                std::span<std::byte> out, std::vector<bool>& is_absent);

/// Decompresses one frame from its fragments.
using DecodeFrame = std::function<Result<void>(ByteReader& file, const EncodedFrame& frame,
                                               std::span<const Fragment>, std::span<std::byte>)>;

/// Finds the fragments of each frame, and decodes them. `absent`: one byte per frame, which becomes
/// 1 if the frame is absent.
Result<void> decode_each(std::span<const EncodedFrame> frames, bool fill_missing,
                         const DecodeFrame& decode, std::span<std::byte> out,
                         std::span<std::byte> absent);

/// The error for a frame that is damaged.
tl::unexpected<Error> decompression_error(const EncodedFrame& frame);

}  // namespace isosplat::import::dicom
