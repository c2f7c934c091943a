#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "shared/import/deflate_decoder.h"
#include "shared/import/hdf5_layout.h"

namespace isosplat {

/// Undoes the filters of chunks. It keeps the memory that decompression needs.
class Hdf5Decoder {
 public:
  Hdf5Decoder();
  Hdf5Decoder(const Hdf5Decoder&) = delete;
  Hdf5Decoder& operator=(const Hdf5Decoder&) = delete;

  /// The elements of a chunk from its bytes in the file. Allocates only what these can become.
  /// Errors: malformed_volume.
  Result<std::vector<std::byte>> decode(const Hdf5File& file, const Hdf5Layout& layout,
                                        std::vector<std::byte> stored, uint32_t mask);

 private:
  /// Decompresses to exactly `bytes` bytes. Nothing if that fails.
  bool inflate(std::span<const std::byte> stored, std::vector<std::byte>& out, uint64_t bytes);

  std::span<const std::byte> input_;  ///< of the decoder, what is left of it
  DeflateDecoder decoder_;
};

}  // namespace isosplat
