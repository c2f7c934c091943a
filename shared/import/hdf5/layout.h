#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "shared/import/hdf5/object.h"

namespace isosplat::import {

/// A filter that the bytes of a chunk pass through when they are written.
enum class Hdf5Filter : uint16_t {
  deflate = 1,
  shuffle = 2,
  fletcher32 = 3,
  lzf = 32000,
  lz4 = 32004,
};

/// The location of an array's elements, in row-major order.
struct Hdf5Layout {
  enum class Index : uint8_t {
    none,      ///< not in chunks: contiguous, at `address`
    tree,      ///< a B-tree of version 1
    single,    ///< one chunk
    implicit,  ///< chunks without filters, one after another
    fixed,     ///< an array of addresses
    growing,   ///< an array of addresses that can grow along one axis
    records,   ///< a B-tree of version 2
  };
  Index index = Index::none;
  uint64_t address = kHdf5Undefined;  ///< of the elements or of the index; undefined: none written
  std::vector<uint64_t> sizes;        ///< along the axes, the slowest first
  std::vector<uint64_t> limits;       ///< maximum sizes to grow to; kHdf5Undefined: no limit
  uint64_t element_bytes = 0;

  // Of chunks:
  std::vector<uint64_t>
      chunk;  ///< sizes of a chunk; chunks at the end of an axis have the same size
  std::vector<Hdf5Filter> filters;  ///< in the order of writing
  std::vector<std::byte> fill;      ///< an element of chunks that do not exist; empty: 0
  bool has_plain_edges = false;     ///< chunks that cross the end of an axis have no filters
  uint64_t single_bytes = 0;        ///< of a single chunk with filters
  uint32_t single_mask = 0;

  uint64_t chunk_bytes() const;
  /// The number of chunks along an axis.
  uint64_t chunks_along(size_t axis) const { return (sizes[axis] + chunk[axis] - 1) / chunk[axis]; }
};

/// The layout of an array with these sizes and elements. Errors: malformed_volume;
/// unsupported_format with the name of the unsupported part.
Result<Hdf5Layout> read_hdf5_layout(const Hdf5File& file, const Hdf5Object& object,
                                    std::vector<uint64_t> sizes, uint64_t element_bytes);

/// A chunk that exists.
struct Hdf5Chunk {
  uint64_t number = 0;  ///< of all chunks, in row-major order
  uint64_t address = 0, bytes = 0;
  uint32_t mask = 0;  ///< bit i: filter i was not used
};

/// All chunks, ascending by number. Errors: malformed_volume, truncated, io_error.
Result<std::vector<Hdf5Chunk>> read_hdf5_chunks(Hdf5File& file, const Hdf5Layout& layout);

}  // namespace isosplat::import
