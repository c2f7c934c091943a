#pragma once

#include <memory>

#include "shared/import/byte_reader.h"
#include "shared/import/hdf5_layout.h"

namespace isosplat {

/// Reads the elements of an array in chunks, in row-major order, as if they were stored so. At most
/// three axes have several elements. It keeps the chunks of the layer that was read last, unless
/// these take more than 512 MiB: then each read decodes all chunks that it touches. Errors: those
/// of read_hdf5_chunks; malformed_volume if no chunk exists.
Result<std::unique_ptr<ByteReader>> open_hdf5_array(std::shared_ptr<Hdf5File> file,
                                                    Hdf5Layout layout);

}  // namespace isosplat
