#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "shared/import/hdf5/file.h"

namespace isosplat::import {

/// A fractal heap. It stores the links of groups, and the attributes of objects, that have many.
class Hdf5Heap {
 public:
  /// Errors: malformed_volume, unsupported_format, those of Hdf5File::read.
  static Result<Hdf5Heap> open(Hdf5File& file, uint64_t address);

  uint64_t id_bytes() const { return id_bytes_; }

  /// The object with an id. Nothing if it is larger than a block ("huge"), which is not supported.
  Result<std::optional<std::vector<std::byte>>> object(Hdf5File& file,
                                                       std::span<const std::byte> id) const;

 private:
  struct Block {
    uint64_t offset = 0, bytes = 0;  ///< in the heap
    uint64_t address = 0;
  };

  Result<void> read_blocks(Hdf5File& file, uint64_t address, uint64_t offset, uint64_t rows,
                           int depth);
  uint64_t row_block_bytes(uint64_t row) const;

  uint64_t header_ = 0;  ///< address of the header
  uint64_t id_bytes_ = 0, offset_bytes_ = 0, size_bytes_ = 0;
  uint64_t width_ = 0, first_block_bytes_ = 0, most_block_bytes_ = 0;
  std::vector<Block> blocks_;  ///< blocks with objects, ascending
};

}  // namespace isosplat::import
