#pragma once

#include <memory>

#include "shared/import/bytes/byte_reader.h"

namespace isosplat::import {

/// Reads voxels of 4 bits as bytes: each byte of `packed` has two, the first one in the low bits.
/// Rows of `columns` voxels begin with a byte of their own; the first one begins at `offset`.
std::unique_ptr<ByteReader> read_nibbles(std::unique_ptr<ByteReader> packed, uint64_t offset,
                                         uint64_t columns);

}  // namespace isosplat::import
