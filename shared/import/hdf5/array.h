#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "shared/import/bytes/byte_reader.h"
#include "shared/import/hdf5/layout.h"
#include "shared/import/voxels/chunked_reader.h"

namespace isosplat::import {

/// Reads a part of an array: see ChunkedReader. Errors: those of read_hdf5_chunks; malformed_volume
/// if no element exists.
Result<std::unique_ptr<ByteReader>> open_hdf5_array(std::shared_ptr<Hdf5File> file,
                                                    Hdf5Layout layout, ArrayPart part);

/// All numbers of a small dataset, in row-major order: at most 2^20. Nothing if it is no such
/// dataset, or none of it was written. `sizes` becomes its sizes. Errors: those of reading it.
Result<std::optional<std::vector<double>>> hdf5_small_array(const std::shared_ptr<Hdf5File>& file,
                                                            const Hdf5Object& object,
                                                            std::vector<uint64_t>& sizes);

}  // namespace isosplat::import
