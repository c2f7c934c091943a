#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "shared/import/codecs/zlib_inflater.h"
#include "shared/import/hdf5/layout.h"

namespace isosplat::import {

/// Reverses the filters of chunks. Keeps its working memory between calls.
class Hdf5Decoder {
 public:
  /// The elements of a chunk, decoded from its bytes in the file. Allocates at most the memory that
  /// these bytes can expand to. Errors: malformed_volume.
  Result<std::vector<std::byte>> decode(const Hdf5File& file, const Hdf5Layout& layout,
                                        std::vector<std::byte> stored, uint32_t mask);

 private:
  ZlibInflater zlib_;
};

}  // namespace isosplat::import
