#pragma once

#include <filesystem>
#include <memory>

#include "native/import/byte_reader.h"
#include "native/import/stored_voxels.h"

namespace isosplat {

/// Voxels that a file has as text from byte `start` on, numbers between white space or commas, as
/// native-endian voxels of `type`. Streams: reading forwards is fast, reading backwards starts
/// again from the beginning. Holds about 64 KB. "nan" and "inf" are voxels of floating-point types.
///
/// Errors: io_error; when read, malformed_volume for a word that is no number of the type, with its
/// place, and truncated where the text ends.
Result<std::unique_ptr<ByteReader>> open_text_voxels(const std::filesystem::path& path,
                                                     uint64_t start, VoxelType type);

/// Bytes that a file has as pairs of hexadecimal digits from byte `start` on, with any white space
/// between them (NRRD's encoding "hex"). Errors: as above.
Result<std::unique_ptr<ByteReader>> open_hex(const std::filesystem::path& path, uint64_t start);

}  // namespace isosplat
