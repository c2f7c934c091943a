#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "shared/import/codecs/zlib_inflater.h"
#include "shared/import/hdf5/layout.h"

namespace isosplat::import {

/// Undoes the filters of chunks. It keeps the memory that decompression needs.
class Hdf5Decoder {
 public:
  /// The elements of a chunk from its bytes in the file. Allocates only what these can become.
  /// Errors: malformed_volume.
  Result<std::vector<std::byte>> decode(const Hdf5File& file, const Hdf5Layout& layout,
                                        std::vector<std::byte> stored, uint32_t mask);

 private:
  ZlibInflater zlib_;
};

}  // namespace isosplat::import
