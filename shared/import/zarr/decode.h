#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "shared/core/base/status.h"
#include "shared/import/zarr/metadata.h"

namespace isosplat::import::zarr {

/// Decodes the bytes of a chunk by its codecs, the last one first. `bytes`: of the decoded chunk;
/// intermediate data may be a little larger. `name`: of the file, for messages. Errors:
/// malformed_volume if the data are damaged, or have another size.
Result<std::vector<std::byte>> decode_chunk(const std::vector<Codec>& codecs,
                                            std::vector<std::byte> stored, size_t bytes,
                                            const std::string& name);

}  // namespace isosplat::import::zarr
