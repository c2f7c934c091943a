#pragma once

#include <functional>

#include "shared/import/hdf5/layout.h"

namespace isosplat::import {

/// An entry of an array of chunks: the location of a chunk. The address of a chunk that does not
/// exist is kHdf5Undefined.
struct Hdf5ChunkEntry {
  uint64_t index = 0;  ///< in the array of chunks
  uint64_t address = kHdf5Undefined, bytes = 0;
  uint32_t mask = 0;
};

using Hdf5ChunkVisitor = std::function<Result<void>(const Hdf5ChunkEntry&)>;

/// Calls `visit` with each chunk in a fixed array of `count` entries, or in an extensible array.
/// Errors: malformed_volume, and those of Hdf5File::read and of `visit`.
Result<void> visit_hdf5_fixed_array(Hdf5File& file, const Hdf5Layout& layout, uint64_t count,
                                    const Hdf5ChunkVisitor& visit);
Result<void> visit_hdf5_growing_array(Hdf5File& file, const Hdf5Layout& layout,
                                      const Hdf5ChunkVisitor& visit);

}  // namespace isosplat::import
