#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "shared/import/hdf5/file.h"

namespace isosplat::import {

/// The objects that the records of a B-tree of version 2 describe.
enum class Hdf5RecordKind : uint8_t {
  link_name = 5,
  attribute_name = 8,
  chunk = 10,
  packed_chunk = 11
};

using Hdf5RecordVisitor = std::function<Result<void>(std::span<const std::byte>)>;

/// Calls `visit` with each record of a B-tree of version 2, in order. The records have at least
/// `least_bytes`. Errors: those of Hdf5File::read and of `visit`.
Result<void> visit_hdf5_records(Hdf5File& file, uint64_t address, Hdf5RecordKind kind,
                                uint64_t least_bytes, const Hdf5RecordVisitor& visit);

/// Whether the last 4 bytes are the checksum of those before them.
bool has_hdf5_checksum(const Hdf5File& file, std::span<const std::byte> bytes);

}  // namespace isosplat::import
