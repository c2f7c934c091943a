#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "shared/import/bytes/byte_reader.h"

namespace isosplat::import {

/// Elements at regular distances in a file, along three axes, the slowest first.
struct StridedBytes {
  uint64_t first = 0;               ///< offset of the first element
  uint64_t element = 1;             ///< bytes of an element; above 0
  std::array<uint64_t, 3> sizes{};  ///< elements; above 0
  std::array<uint64_t, 3> steps{};  ///< bytes from an element to the next one
};

/// Reads these elements as if they were stored one after the other. The last element lies within
/// the file's 2^64 bytes. `file`: with random access.
std::unique_ptr<ByteReader> read_strided(std::unique_ptr<ByteReader> file,
                                         const StridedBytes& elements);

}  // namespace isosplat::import
