#pragma once

#include <memory>

#include "shared/import/bytes/byte_reader.h"

namespace isosplat::import {

/// Reads 4-bit voxels as bytes: each byte of `packed` has two, the first one in the low bits. Rows
/// of `columns` voxels begin at byte boundaries; the first row begins at `offset`.
std::unique_ptr<ByteReader> read_nibbles(std::unique_ptr<ByteReader> packed, uint64_t offset,
                                         uint64_t columns);

}  // namespace isosplat::import
