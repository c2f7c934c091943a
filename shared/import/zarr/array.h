#pragma once

#include <memory>
#include <string>
#include <vector>

#include "shared/import/voxels/chunked_reader.h"
#include "shared/import/zarr/metadata.h"

namespace isosplat::import::zarr {

/// Reads a part of an array from the files of its chunks or shards. `notes`: receives the number of
/// chunks that are absent, if there are some; their elements have the fill value. Errors of
/// reading: those of decode_chunk, io_error.
std::unique_ptr<ByteReader> open_array(const Node& node, const ArrayPart& part,
                                       std::vector<std::string>& notes);

}  // namespace isosplat::import::zarr
